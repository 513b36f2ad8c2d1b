"""Writes the crates (.usdc) of the tests from USD texts: its own reading of both forms, apart from the renderer's.

The texts are those of tests: values, time samples, metadata, and references within the layer. LZ4 is liblz4's.
"""
import ctypes
import re
import struct

LZ4 = ctypes.CDLL("liblz4.so.1")
# The name of a type: its code, the letter of a number (of struct), and how many make a value.
NUMBERS = {"bool": (1, "B", 1), "uchar": (2, "B", 1), "int": (3, "i", 1), "uint": (4, "I", 1), "int64": (5, "q", 1),
           "uint64": (6, "Q", 1), "half": (7, "e", 1), "float": (8, "f", 1), "double": (9, "d", 1),
           "matrix4d": (15, "d", 16), "quatd": (16, "d", 4), "quatf": (17, "f", 4), "quath": (18, "e", 4),
           "timecode": (56, "d", 1)}
for size, first in ((2, 19), (3, 23), (4, 27)):
    for place, letter in enumerate(("double", "float", "half", "int")):
        NUMBERS["%s%d" % (letter, size)] = (first + place, NUMBERS[letter][1], size)
ROLE = re.compile("(point|normal|vector|color|texCoord)([234])([hfd])")
WORD = {"h": "half", "f": "float", "d": "double"}
TOKEN, STRING, ASSET = 11, 10, 12
TOKENS = re.compile(r'\s+|#[^\n]*|"""(?:.|\n)*?"""|"(?:\\.|[^"\\])*"|\'[^\']*\'|@[^@]*@|<[^>]*>|'
                    r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?!\w)|[-+]?inf\b|nan\b|[^\W\d][\w:.]*|[][{}()=,:;]')


class Text:
    """A USD text as a list of specs: path, kind, and fields as (key, kind of value, value)."""

    def __init__(self, text):
        self.words, at = [], 0
        while at < len(text):
            found = TOKENS.match(text, at)
            assert found, text[at:at + 40]
            at = found.end()
            if not found.group().isspace() and not found.group().startswith("#"):
                self.words.append(found.group())
        self.at, self.specs = 0, []
        root = []
        if self.peek() == "(":
            self.metadata(root, {"metersPerUnit": "double", "upAxis": "token", "timeCodesPerSecond": "double", "doc": "string",
                                 "defaultPrim": "token"})
        self.specs.append(("/", 7, root))
        names = []
        while self.peek():
            names.append(self.prim(""))
        root.append(("primChildren", "tokens", names))

    def peek(self):
        return self.words[self.at] if self.at < len(self.words) else ""

    def take(self, *wanted):
        word = self.peek()
        if wanted and word not in wanted:
            return ""
        self.at += 1
        return word

    def value(self):
        """Numbers and names, in lists as brackets have them."""
        word = self.take()
        if word in "([":
            items = []
            while not self.take(")", "]"):
                items.append(self.value())
                self.take(",")
            return items
        if word[0] in "\"'":
            return word.strip("\"'")
        if word in ("None", "true", "false"):
            return {"None": None, "true": 1, "false": 0}[word]
        return word if word[0] in "<@" else float(word) if re.match("[-+]?[0-9.in]", word) else word

    def metadata(self, fields, types):
        self.take("(")
        while not self.take(")"):
            key = self.take()
            if key[0] in "\"'":
                fields.append(("documentation", "string", key.strip("\"'")))
                continue
            order = key if key in ("prepend", "append", "add", "delete") else ""
            if order:
                key = self.take()
            self.take("=")
            value = self.value()
            if key in ("references", "payload", "inherits", "specializes"):
                offset = []
                if self.peek() == "(":
                    self.metadata(offset, {"offset": "double"})
                targets = value if isinstance(value, list) else [value]
                fields.append(("inheritPaths" if key == "inherits" else key, key, (order, targets, offset[0][2] if offset else 0)))
            elif key in types:
                fields.append((key, types[key], value))

    def prim(self, parent):
        specifier, kind = self.take(), ""
        if self.peek()[0] not in "\"'":
            kind = self.take()
        name = self.take().strip("\"'")
        path, fields = parent + "/" + name, [("specifier", "specifier", ("def", "over", "class").index(specifier))]
        self.specs.append((path, 6, fields))
        if kind:
            fields.append(("typeName", "token", kind))
        if self.peek() == "(":
            self.metadata(fields, {"active": "bool", "instanceable": "bool", "kind": "token", "clipAssetPaths": "asset[]",
                                   "inactiveIds": "ids"})
        properties, children = {}, []
        self.take("{")
        while not self.take("}"):
            if self.peek() in ("def", "over", "class"):
                children.append(self.prim(path))
            elif not self.take(";"):
                self.attribute(properties)
        for its_name, (kind, its) in properties.items():
            self.specs.append((path + "." + its_name, kind, its))
        fields.append(("properties", "tokens", list(properties)))
        fields.append(("primChildren", "tokens", children))
        return name

    def attribute(self, properties):
        word = self.take()
        while word in ("custom", "uniform"):
            word = self.take()
        kind = word
        if self.take("["):
            self.take("]")
            kind += "[]"
        name = self.take()
        samples = name.endswith(".timeSamples")
        name = name.removesuffix(".timeSamples")
        _, fields = properties.setdefault(name, (8 if kind == "rel" else 1, [("typeName", "token", kind)]))
        if self.take("="):
            if samples:
                self.take("{")
                values = []
                while not self.take("}"):
                    time = self.value()
                    self.take(":")
                    values.append((time, self.value()))
                    self.take(",")
                fields.append(("timeSamples", "samples", (kind, values)))
            else:
                value = self.value()
                if kind == "rel":
                    fields.append(("targetPaths", "inherits", ("", value if isinstance(value, list) else [value], 0)))
                else:
                    fields.append(("default", kind, value))
        if self.peek() == "(":
            self.metadata(fields, {"interpolation": "token", "colorSpace": "token"})


def flat(value):
    return [n for item in value for n in flat(item)] if isinstance(value, list) else [value]


def packed(content):
    room = LZ4.LZ4_compressBound(len(content))
    out = ctypes.create_string_buffer(room)
    size = LZ4.LZ4_compress_default(bytes(content), out, len(content), room)
    return b"\0" + out.raw[:size]


def integers(values, size=4):
    """The crate's coding: differences, the most common one by 2 bits alone, the others as small as they are."""
    if not values:
        return struct.pack("<Q", 0)
    bits, steps = 8 * size, []
    for before, here in zip([0] + values, values):
        step = (here - before) % (1 << bits)
        steps.append(step - (1 << bits) if step >> (bits - 1) else step)
    common = max(sorted(set(steps)), key=steps.count)
    codes, rest = bytearray((len(values) + 3) // 4), b""
    for i, step in enumerate(steps):
        if step == common:
            continue
        bits_of = {c: 2 * size << (c - 1) for c in (1, 2, 3)}
        code = next(c for c, bits in bits_of.items() if -1 << (bits - 1) <= step < 1 << (bits - 1))
        codes[i // 4] |= code << (2 * (i % 4))
        rest += step.to_bytes(size // 4 << (code - 1), "little", signed=True)
    content = packed(common.to_bytes(size, "little", signed=True) + codes + rest)
    return struct.pack("<Q", len(content)) + content


class Crate:
    def __init__(self, text, minor=8):
        self.minor, self.bytes = minor, bytearray(88)
        self.tokens, self.strings, self.fields, self.sets, self.paths = [";-)"], [], [], [], {}
        specs = [(path, kind, [(key, self.rep(kind_of, value)) for key, kind_of, value in fields])
                 for path, kind, fields in Text(text).specs]
        self.sections(specs)

    def index(self, table, item):
        if item not in table:
            table.append(item)
        return table.index(item)

    def token(self, text):
        return self.index(self.tokens, text)

    def string(self, text):
        return self.index(self.strings, self.token(text))

    def path(self, path):
        return self.paths.setdefault(path, len(self.paths))

    def put(self, content):
        self.bytes += bytes(-len(self.bytes) % 8)
        at = len(self.bytes)
        self.bytes += content
        return at

    @staticmethod
    def inlined(code, number):
        return 1 << 62 | code << 48 | number

    def array(self, code, count, content, is_packed=False):
        if count == 0:
            return 1 << 63 | code << 48
        head = struct.pack("<I", 1) if self.minor < 5 else b""
        head += struct.pack("<I" if self.minor < 7 else "<Q", count)
        return 1 << 63 | is_packed << 61 | code << 48 | self.put(head + content)

    def rep(self, kind, value):
        if value is None:
            return self.inlined(51, 0)
        if kind == "specifier":
            return self.inlined(42, value)
        if kind == "tokens":
            return 41 << 48 | self.put(struct.pack("<Q%dI" % len(value), len(value), *map(self.token, value)))
        if kind in ("references", "payload", "inherits", "specializes"):
            return self.arcs(kind, *value)
        if kind == "ids":
            return 37 << 48 | self.put(struct.pack("<BQ%dq" % len(value), 3, len(value), *map(int, value)))
        if kind == "samples":
            return self.samples(*value)
        is_array, kind = kind.endswith("[]"), kind.removesuffix("[]")
        role = ROLE.fullmatch(kind)
        kind = WORD[role[3]] + role[2] if role else kind
        if kind in ("token", "string", "asset"):
            code = {"token": TOKEN, "string": STRING, "asset": ASSET}[kind]
            numbers = [self.string(t) if kind == "string" else self.token(t.strip("@")) for t in flat([value])]
            if not is_array:
                return self.inlined(code, numbers[0])
            return self.array(code, len(numbers), struct.pack("<%dI" % len(numbers), *numbers))
        code, letter, size = NUMBERS[kind]
        numbers = flat([value])
        if letter in "BiIqQ":
            numbers = [int(n) for n in numbers]
        if kind.startswith("quat"):
            numbers = [n for at in range(0, len(numbers), 4) for n in numbers[at + 1:at + 4] + numbers[at:at + 1]]
        content = struct.pack("<%d%s" % (len(numbers), letter), *numbers)
        return self.numbers(code, letter, size, numbers, content) if is_array else self.single(code, letter, size, numbers, content)

    def numbers(self, code, letter, size, numbers, content):
        count = len(numbers) // size
        if count < 16 or size > 1 or letter == "B" or self.minor < (5 if letter in "iIqQ" else 6):
            return self.array(code, count, content)
        if letter in "iIqQ":
            return self.array(code, count, integers(numbers, 8 if letter in "qQ" else 4), True)
        if all(n == int(n) for n in numbers):
            return self.array(code, count, b"i" + integers([int(n) for n in numbers]), True)
        table = sorted(set(numbers))
        if len(table) > count // 4:
            return self.array(code, count, content)
        rows = struct.pack("<I%d%s" % (len(table), letter), len(table), *table)
        return self.array(code, count, b"t" + rows + integers([table.index(n) for n in numbers]), True)

    def single(self, code, letter, size, numbers, content):
        small = all(n == int(n) and -128 <= n < 128 for n in numbers)
        if size == 16 and small and all(n == 0 for i, n in enumerate(numbers) if i % 5):
            return self.inlined(code, int.from_bytes(struct.pack("4b", *(int(n) for n in numbers[::5])), "little"))
        if 1 < size < 16 and code > 18 and small:
            return self.inlined(code, int.from_bytes(struct.pack("%db" % size, *map(int, numbers)), "little"))
        if len(content) <= 4:
            return self.inlined(code, int.from_bytes(content, "little"))
        if size == 1 and letter == "d" and struct.unpack("f", struct.pack("f", numbers[0]))[0] == numbers[0]:
            return self.inlined(code, int.from_bytes(struct.pack("<f", numbers[0]), "little"))
        if size == 1 and letter in "qQ" and 0 <= numbers[0] < 1 << 31:
            return self.inlined(code, numbers[0])
        return code << 48 | self.put(content)

    def arcs(self, kind, order, targets, offset):
        items = b""
        for target in targets:
            file, path = ("", target) if target[0] == "<" else (target.strip("@"), "<>")
            number = struct.pack("<I", self.path(path.strip("<>") or ""))
            if kind in ("inherits", "specializes"):
                items += number
            elif kind == "references":  # with custom data of one key
                items += struct.pack("<I", self.string(file)) + number + struct.pack("<ddQIqQ", offset, 1, 1, self.string("note"), 8, self.rep("int", 7))
            else:
                items += struct.pack("<I", self.string(file)) + number + (struct.pack("<dd", offset, 1) if self.minor >= 8 else b"")
        if kind == "payload" and self.minor < 8:
            return 47 << 48 | self.put(items)
        bit = {"": 3, "add": 4, "prepend": 32, "append": 64, "delete": 8}[order]
        code = {"references": 35, "payload": 55}.get(kind, 34)
        return code << 48 | self.put(struct.pack("<BQ", bit, len(targets)) + items)

    def samples(self, kind, values):
        times = 48 << 48 | self.put(struct.pack("<Q%dd" % len(values), len(values), *(time for time, _ in values)))
        reps = [self.rep(kind, value) for _, value in values]
        return 46 << 48 | self.put(struct.pack("<qQqQ%dQ" % len(reps), 8, times, 8, len(reps), *reps))

    def sections(self, specs):
        rows = []
        for path, kind, fields in specs:
            first = len(self.sets)
            for key, rep in fields:
                field = (self.token(key), rep)
                self.sets.append(self.index(self.fields, field))
            self.sets.append(-1)
            rows.append((self.path(path), first, kind))
        tree = self.tree([path for path, _, _ in specs])
        toc = []

        def section(name, content):
            toc.append((name, self.put(content), len(content)))

        def number(n):
            return struct.pack("<Q", n)

        characters = b"".join(t.encode() + b"\0" for t in self.tokens)
        section("TOKENS", number(len(self.tokens)) + number(len(characters)) + number(len(packed(characters))) + packed(characters))
        section("STRINGS", number(len(self.strings)) + struct.pack("<%dI" % len(self.strings), *self.strings))
        reps = packed(b"".join(number(rep) for _, rep in self.fields))
        section("FIELDS", number(len(self.fields)) + integers([t for t, _ in self.fields]) + number(len(reps)) + reps)
        section("FIELDSETS", number(len(self.sets)) + integers(self.sets))
        section("PATHS", number(len(self.paths)) + number(len(tree)) + b"".join(integers(list(column)) for column in zip(*tree)))
        section("SPECS", number(len(rows)) + b"".join(integers(list(column)) for column in zip(*rows)))
        at = self.put(number(len(toc)) + b"".join(struct.pack("<16sqq", name.encode(), *where) for name, *where in toc))
        self.bytes[:24] = struct.pack("<8s8Bq", b"PXR-USDC", 0, self.minor, 0, 0, 0, 0, 0, 0, at)

    def tree(self, paths):
        """Rows of the paths' numbers, tokens and jumps: children sorted, as no text has them."""
        children = {path: [] for path in paths}
        for path in paths:
            if path != "/":
                cut = max(path.rfind("/"), path.rfind("."))
                children[path[:cut] or "/"].append(path)
        rows = []

        def add(path, is_last):
            row = len(rows)
            cut = max(path.rfind("/"), path.rfind("."))
            name = self.token(path[cut + 1:])
            rows.append([self.path(path), -name if path[cut] == "." else name, 0])
            below = sorted(children[path])
            for child in below:
                add(child, child == below[-1])
            rows[row][2] = (-1 if below else -2) if is_last else (len(rows) - row if below else 0)

        add("/", True)
        return rows


def crate(text, minor=8):
    return bytes(Crate(text, minor).bytes)
