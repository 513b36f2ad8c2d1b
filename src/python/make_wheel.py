#!/usr/bin/env python3
"""Makes a wheel of a built package: make_wheel.py BUILD/python/tress FOLDER --version 0.2.0

The name says for which Python and machine the compiled part was built (PEP 425, 427); the bytes depend on nothing but the
files.
"""
import argparse
import base64
import hashlib
import pathlib
import sysconfig
import zipfile

METADATA = """Metadata-Version: 2.1
Name: tress
Version: {version}
Summary: Renders hair and fur whose fibers have elliptical cross-sections
Requires-Python: >=3.10
Requires-Dist: numpy>=1.24
"""
WHEEL = """Wheel-Version: 1.0
Generator: tress make_wheel
Root-Is-Purelib: false
Tag: {tag}
"""


def record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--version", required=True)
    arguments = parser.parse_args()
    python = "cp" + sysconfig.get_config_var("py_version_nodot")
    tag = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    compiled = "_tress" + sysconfig.get_config_var("EXT_SUFFIX")
    if not (arguments.package / compiled).is_file():
        raise SystemExit(f"{arguments.package}: expected {compiled}, of this Python, found none")
    files = {}
    for path in sorted(arguments.package.iterdir()):
        if path.suffix in (".py", ".pyi", ".typed") or path.name in ("py.typed", compiled):
            files[f"tress/{path.name}"] = path.read_bytes()
    info = f"tress-{arguments.version}.dist-info"
    files[f"{info}/METADATA"] = METADATA.format(version=arguments.version).encode()
    files[f"{info}/WHEEL"] = WHEEL.format(tag=tag).encode()
    record = [record_line(name, data) for name, data in files.items()] + [f"{info}/RECORD,,"]
    files[f"{info}/RECORD"] = ("\n".join(record) + "\n").encode()
    target = arguments.folder / f"tress-{arguments.version}-{tag}.whl"
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o755 if name.endswith(compiled) else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    print(target)


if __name__ == "__main__":
    main()
