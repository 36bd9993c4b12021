#!/usr/bin/env python3
"""The Debian package of a build: its contents, the program in it, and a program that links the library in it.

    check_package.py --build build/ [--verbose]

The package is unpacked into a temporary folder. Without dpkg and cpack the installed tree is checked alone; lintian and
man are asked where they are installed.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from tool import Tally, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "tests" / "documentation" / "budget.cpp"
WANTED = ["bin/qerr", "include/qerr/qerr.hpp", "share/qerr/qerr.schema.json", "share/qerr/configs/kuka_lwr/spec.yaml",
          "share/qerr/scripts/plot_diagnosis.py", "share/doc/qerr/copyright", "share/doc/qerr/README.md",
          "share/bash-completion/completions/qerr", "share/zsh/site-functions/_qerr",
          "share/fish/vendor_completions.d/qerr.fish", "share/doc/qerr/changelog.Debian.gz", "share/man/man1/qerr.1.gz",
          "share/man/man7/qerr-spec.7.gz"]
# The example takes seconds to compile, for all that qerr.hpp includes: once, by CMake. By pkg-config its object is linked beside
# this, which needs the include folders; by ament this is a program of its own.
SHORT = """#include <iostream>

#include "qerr/report/write.hpp"
#if !__has_include(<Eigen/Core>)
#error "Eigen is not found"
#endif
"""
SHORT_PROGRAM = SHORT + """
int main() { std::cout << qerr::formats().front().name; }
"""
INSTALLED_ONLY = ("share/doc/qerr/changelog.Debian.gz",)


def command(*words, **more):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, **more)


def packed(t, build, scratch):
    """The folder usr/ of the package; of two packages of one build, all bytes must be the same."""
    packages = []
    for name in ("first", "second"):
        done = command("cpack", "--config", build / "CPackConfig.cmake", "-B", scratch / name,
                       env=dict(os.environ, SOURCE_DATE_EPOCH="1700000000"), cwd=scratch)
        found = list((scratch / name).glob("qerr_*.deb"))
        if not t.check(f"cpack makes one package ({name})", done.returncode == 0 and len(found) == 1, done.stderr[-500:]):
            return None
        packages += found
    t.check("the same bytes again", packages[0].read_bytes() == packages[1].read_bytes())
    depends = command("dpkg-deb", "--field", packages[0], "Depends").stdout
    t.check("the shared libraries are dependencies", re.search(r"\blibc6 .*\byaml-cpp|libyaml-cpp", depends), depends)
    t.check("packages for development are not needed to run", "-dev" not in depends, depends)
    if shutil.which("lintian"):
        said = command("lintian", "--fail-on", "error", "--tag-display-limit", "0", packages[0]).stdout
        t.check("lintian finds no error", not re.search(r"^E:", said, re.M), said)
    command("dpkg-deb", "--extract", packages[0], scratch / "root", check=True)
    return scratch / "root" / "usr"


def installed(t, build, scratch):
    done = command("cmake", "--install", build, "--prefix", scratch / "root" / "usr")
    t.check("cmake --install", done.returncode == 0, done.stderr[-500:])
    return scratch / "root" / "usr"


def check_tree(t, usr, is_package):
    for name in WANTED:
        if not is_package:
            name = name.removesuffix(".gz") if "/man/" in name else name
        if is_package:  # where Debian's zsh looks
            name = name.replace("zsh/site-functions", "zsh/vendor-completions")
        if is_package or name not in INSTALLED_ONLY:
            t.check(f"has {name}", (usr / name).is_file())
    t.check("has a man page for each command", len(list((usr / "share/man/man1").iterdir())) > 10)
    named = [str(ROOT).encode()]
    holding = [p for p in usr.rglob("*") if p.is_file() and any(n in p.read_bytes() for n in named)]
    t.check("no file holds a path of this build", not holding, str(holding[:3]))


def check_program(t, usr):
    qerr = usr / "bin" / "qerr"
    ran = run(qerr, "analyze", "-q", usr / "share/qerr/configs/kuka_lwr/spec.yaml")
    t.check("the program analyzes a config of the package", ran.code == 0 and b"kuka" in ran.out, str(ran.err[-300:]))
    ran = run(qerr, "schema")
    t.check("the schema is that of the program", ran.out == (usr / "share/qerr/qerr.schema.json").read_bytes())
    if shutil.which("man"):
        page = command("man", "-M", usr / "share/man", "qerr", env=dict(os.environ, MANPAGER="cat", MANWIDTH="80"))
        t.check("man qerr", page.returncode == 0 and "analyze" in page.stdout, page.stderr)


def check_library(t, usr, scratch):
    """The example of `qerr help library`, compiled outside the project, by CMake and by pkg-config."""
    (scratch / "example").mkdir()
    shutil.copy(EXAMPLE, scratch / "example")
    topic = (ROOT / "src" / "cli" / "topics" / "library.md").read_text()
    block = re.search(r"```cmake\n(cmake_minimum_required.*?)```", topic, re.S)
    if not t.check("the topic has the example's CMakeLists.txt", block):
        return
    t.check("the topic has the example", f"```cpp\n{EXAMPLE.read_text()}```" in topic)
    (scratch / "example" / "CMakeLists.txt").write_text(block[1])
    # Ninja, as scripts/setup.sh installs it: the default generator needs make, which a fresh machine does not have.
    done = command("cmake", "-G", "Ninja", "-S", scratch / "example", "-B", scratch / "made", f"-DCMAKE_PREFIX_PATH={usr}")
    t.check("find_package(qerr) finds it", done.returncode == 0, done.stderr[-800:])
    done = command("cmake", "--build", scratch / "made")
    t.check("the example is built", done.returncode == 0, done.stdout[-800:] + done.stderr[-800:])
    if done.returncode == 0:
        check_budget(t, scratch / "made" / "budget", usr)
    check_ament(t, usr, scratch, topic)
    line = re.search(r"^c\+\+ .*pkg-config.*$", topic, re.M)
    described = list(usr.glob("lib/**/pkgconfig/qerr.pc"))
    if not t.check("the topic has the example of pkg-config, the tree its file", line and len(described) == 1) or not shutil.which("pkg-config"):
        return
    (scratch / "example" / "short.cpp").write_text(SHORT)
    made = next((scratch / "made").rglob("budget.cpp.o"))
    done = command("bash", "-c", line[0].replace(" budget.cpp ", f" short.cpp {made} "), cwd=scratch / "example", env=dict(os.environ, PKG_CONFIG_PATH=str(described[0].parent)))
    if t.check("the example is built by pkg-config", done.returncode == 0, done.stderr[-800:]):
        check_budget(t, scratch / "example" / "budget", usr)


def check_ament(t, usr, scratch, topic):
    """The package by ament of the same topic, where ament_cmake is installed."""
    blocks = [re.search(pattern, topic, re.S) for pattern in (r"```text\n(<package.*?)```", r"```cmake\n([^`]*?ament_package\(\)\n)```")]
    if not t.check("the topic has a package by ament", all(blocks)) or not pathlib.Path("/usr/share/ament_cmake").is_dir():
        return
    source, made = scratch / "ament", scratch / "ament_made"
    shutil.copytree(scratch / "example", source)
    (source / "budget.cpp").write_text(SHORT_PROGRAM)
    for name, block in zip(("package.xml", "CMakeLists.txt"), blocks):
        (source / name).write_text(block[1])
    done = command("cmake", "-G", "Ninja", "-S", source, "-B", made, f"-DCMAKE_PREFIX_PATH={usr}", f"-DCMAKE_INSTALL_PREFIX={made / 'prefix'}",
                   "-DPython3_EXECUTABLE=/usr/bin/python3")  # whose modules are those of ament
    done = done if done.returncode else command("cmake", "--build", made, "--target", "install")
    if t.check("a package by ament finds it", done.returncode == 0, done.stdout[-800:] + done.stderr[-800:]):
        done = command(made / "prefix" / "lib" / "budget" / "budget")
        t.check("and runs", done.returncode == 0 and done.stdout == "table", done.stdout + done.stderr)


def check_budget(t, program, usr):
    done = command(program, cwd=usr / "share/qerr/configs/kuka_lwr")
    t.check("and runs", re.match(r"velocity: [0-9.e-]+ m/s\n{", done.stdout), done.stderr)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", required=True, type=pathlib.Path)
    parser.add_argument("--verbose", action="store_true")
    given = parser.parse_args()
    t, build = Tally(given.verbose), given.build.resolve()
    is_package = bool(shutil.which("dpkg-deb") and shutil.which("dpkg-shlibdeps") and shutil.which("cpack"))
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        usr = (packed if is_package else installed)(t, build, scratch)
        if usr:
            check_tree(t, usr, is_package)
            check_program(t, usr)
            check_library(t, usr, scratch)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
