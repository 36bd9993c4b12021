# The Debian package, which `cpack` makes: the program, the library with its headers and CMake package, man pages,
# completions, schema, configs and the script that plots. scripts/package.sh builds it reproducibly.
set(package_folder ${CMAKE_CURRENT_LIST_DIR})
install(FILES ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME qerr)
set(CPACK_PACKAGE_CONTACT "the qerr authors <maintainers@qerr.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "design calculator for encoder quantization error in robots")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
    "qerr computes what the steps of a robot's encoders do at its tip: errors of
position, velocity and acceleration, in the worst case and as a standard
deviation, over the whole workspace. It chooses encoders, gears and filters by
requirements, and finds in a measured log which effects a model lacks.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${package_folder}/finish.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# What a program that links the library is compiled with; the program qerr needs none of it.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
    "libboost-dev, libeigen3-dev, libexpat1-dev, liblz4-dev, libsqlite3-dev, liburdfdom-dev, libyaml-cpp-dev, libzstd-dev, nlohmann-json3-dev")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "gnuplot, jq, parallel, python3, python3-matplotlib, python3-numpy")
# A package of its own, which `cpack -D CPACK_COMPONENTS_ALL=python -D CPACK_DEB_COMPONENT_INSTALL=ON` makes: the other
# one leaves this component out.
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-qerr)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-pandas")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "qerr")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${package_folder}/prerm)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "the commands of qerr as functions of Python
Reports as dicts and as rows for pandas, logs as NumPy arrays, errors as
exceptions.")
include(CPack)
