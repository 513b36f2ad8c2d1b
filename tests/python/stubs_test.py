"""_tress.pyi is the compiled module: the same names, methods, properties, parameters and defaults."""

import ast
import inspect
import re
import unittest

import tress
from support import SOURCE
from tress import _tress

STUB = ast.parse((SOURCE / "src/python/tress/_tress.pyi").read_text())


def of_stub(function, is_method):
    """Parameters with their defaults, as text."""
    arguments = function.args
    names = [argument.arg for argument in arguments.args][1 if is_method else 0 :]
    defaults = [None] * (len(names) - len(arguments.defaults)) + [ast.unparse(x) for x in arguments.defaults]
    keyword = [(one.arg, ast.unparse(x)) for one, x in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    return [(name, value) for name, value in zip(names, defaults)] + keyword


def of_module(function, is_method):
    """The same, of the signature that pybind11 writes into the docstring."""
    line = function.__doc__.splitlines()[0]
    inside = line[line.index("(") + 1 : line.rindex(") ->")]
    depth, parts, part = 0, [], ""
    for letter in inside:
        depth += letter in "[(" and 1 or (letter in "])" and -1 or 0)
        if letter == "," and depth == 0:
            parts, part = [*parts, part], ""
        else:
            part += letter
    parameters = []
    for part in [one.strip() for one in [*parts, part] if one.strip() and one.strip() != "*"]:
        name = re.match(r"\w+", part)[0]
        default = part.rsplit(" = ", 1)[1] if " = " in part else None
        parameters.append((name, default))
    return parameters[1 if is_method else 0 :]


class Stubs(unittest.TestCase):
    def test_have_the_names_of_the_module(self):
        stub = {node.name for node in STUB.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        stub |= {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
        module = {name for name in vars(_tress) if not name.startswith("_")} | {"__version__"}
        self.assertEqual(stub, module)

    def test_have_the_members_of_every_class(self):
        for node in STUB.body:
            if not isinstance(node, ast.ClassDef):
                continue
            if issubclass(getattr(_tress, node.name), tress.Error):
                bases = [kind.__name__ for kind in getattr(_tress, node.name).__bases__]
                self.assertEqual([ast.unparse(base) for base in node.bases], bases)
                continue
            members = {one.name: one for one in node.body if isinstance(one, ast.FunctionDef)}
            kind = getattr(_tress, node.name)
            module = {name for name in vars(kind) if not name.startswith("_")}
            self.assertEqual({name for name in members if name != "__init__"}, module, node.name)
            for name, member in members.items():
                is_property = any(isinstance(x, ast.Name) and x.id == "property" for x in member.decorator_list)
                self.assertEqual(is_property, isinstance(inspect.getattr_static(kind, name), property), name)
                if not is_property:
                    self.assertEqual(of_stub(member, True), of_module(getattr(kind, name), True), name)

    def test_have_the_parameters_of_every_function(self):
        functions = [node for node in STUB.body if isinstance(node, ast.FunctionDef)]
        self.assertGreater(len(functions), 5)
        for node in functions:
            stub = [(name, value.strip("'\"") if value else value) for name, value in of_stub(node, False)]
            module = [(name, value.strip("'\"") if value else value) for name, value in of_module(getattr(_tress, node.name), False)]
            self.assertEqual(stub, module, node.name)

    def test_all_names_of_the_package_are_there(self):
        for name in tress.__all__:
            self.assertTrue(hasattr(tress, name), name)
        self.assertEqual(sorted(tress.__all__), tress.__all__)
        self.assertEqual(len(tress.LOBES), 6)


if __name__ == "__main__":
    unittest.main()
