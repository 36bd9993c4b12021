# Looks for what the tests need besides qerr's own packages. Sets QERR_TESTS_LACK to the missing ones.
set(QERR_TESTS_LACK "")

find_package(GTest QUIET)
if(NOT GTest_FOUND)
  list(APPEND QERR_TESTS_LACK GoogleTest)
endif()

# KDL is the independent reference for kinematics and dynamics.
find_path(OROCOS_KDL_INCLUDE_DIR kdl/chain.hpp)
find_library(OROCOS_KDL_LIBRARY NAMES orocos-kdl)
if(NOT OROCOS_KDL_INCLUDE_DIR OR NOT OROCOS_KDL_LIBRARY)
  list(APPEND QERR_TESTS_LACK KDL)
endif()

# RapidCheck draws random cases and shrinks those that fail.
find_path(RAPIDCHECK_INCLUDE_DIR rapidcheck/gtest.h)
find_library(RAPIDCHECK_LIBRARY NAMES rapidcheck)
if(NOT RAPIDCHECK_INCLUDE_DIR OR NOT RAPIDCHECK_LIBRARY)
  list(APPEND QERR_TESTS_LACK RapidCheck)
endif()

find_path(VALIJSON_INCLUDE_DIR valijson/validator.hpp)
if(NOT VALIJSON_INCLUDE_DIR)
  list(APPEND QERR_TESTS_LACK Valijson)
endif()

# The system's own interpreter: Debian installs its modules for this one only.
find_program(QERR_TEST_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(QERR_TEST_PYTHON)
  execute_process(COMMAND ${QERR_TEST_PYTHON} -c "import numpy, jsonschema" RESULT_VARIABLE modules_status OUTPUT_QUIET ERROR_QUIET)
endif()
if(NOT QERR_TEST_PYTHON)
  list(APPEND QERR_TESTS_LACK "python3 (in /usr/bin)")
elseif(NOT modules_status EQUAL 0)
  list(APPEND QERR_TESTS_LACK "numpy or jsonschema")
endif()
