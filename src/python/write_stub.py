"""Writes qerr/__init__.pyi, the types of the package for checkers such as mypy, from the module that has been built.

    write_stub.py FOLDER    of the package `qerr`
"""
import importlib
import inspect
import pathlib
import re
import sys

HEAD = '''import builtins
import os
from typing import Any, Iterable, Mapping, Union

__version__: str
Path = Union[str, "os.PathLike[str]"]
Log = Union[Path, Mapping[str, Any]]

'''


def members(kind):
    """The public attributes and methods of a class."""
    lines = [f"    {name}: {of}" for name, of in getattr(kind, "__annotations__", {}).items()]
    for name, value in vars(kind).items():
        if isinstance(value, property):
            lines += ["    @property", f"    def {name}{inspect.signature(value.fget)}: ..."]
        elif inspect.isfunction(value) and not name.startswith("_"):
            lines.append(f"    def {name}{inspect.signature(value)}: ...")
    return lines or ["    ..."]


def main():
    folder = pathlib.Path(sys.argv[1])
    sys.path.insert(0, str(folder.parent))
    module = importlib.import_module("qerr")
    text = HEAD
    for name, value in vars(module).items():
        if name.startswith("_") or getattr(value, "__module__", "") != "qerr":
            continue
        if inspect.isclass(value):
            text += f"class {name}({value.__base__.__name__}):\n" + "\n".join(members(value)) + "\n\n"
        elif inspect.isfunction(value):
            signature = str(inspect.signature(value)).replace("'", "")
            text += f"def {name}{signature}: ...\n"
    text = re.sub(r"\blist\[", "builtins.list[", text)  # a function of the module is called so, too
    (folder / "__init__.pyi").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
