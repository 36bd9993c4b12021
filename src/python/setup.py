"""Builds the module with CMake; everything else is in pyproject.toml."""
import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parents[2]


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        build = ROOT / "build" / "wheel"
        subprocess.run(["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DQERR_PYTHON=ON", "-DQERR_TESTS=OFF",
                        f"-DPython_EXECUTABLE={sys.executable}"], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "qerr_python", "--parallel"], check=True)
        module = next((build / "python" / "qerr").glob("_qerr*.so"))
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(module.read_bytes())
        (target.parent / "__init__.pyi").write_bytes((module.parent / "__init__.pyi").read_bytes())


setup(ext_modules=[Extension("qerr._qerr", [])], cmdclass={"build_ext": CMakeBuild})
