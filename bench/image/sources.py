"""Where the scenes and grooms are that the scripts of this folder measure."""
import os

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(os.path.dirname(ROOT), "shared", "data")


def source_of(name):
    """The path of a file of the project, or of the data beside it; None where it is absent, which is printed."""
    found = next((path for path in (os.path.join(ROOT, name), os.path.join(DATA, name)) if os.path.exists(path)), None)
    if not found:
        print(f"{name}: absent, left out")
    return found
