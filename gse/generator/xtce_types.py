# SPDX-License-Identifier: Apache-2.0
"""Space systems and types of an XTCE 1.2 database, for parameters and arguments. `what` is "Parameter" or "Argument": XTCE has separate
types for them, whose elements contain this word in their names."""

import xml.etree.ElementTree as ET

NAMESPACE = "http://www.omg.org/spec/XTCE/20180204"
SCHEMA = "https://www.omg.org/spec/XTCE/20180204/SpaceSystem.xsd"
SCALARS = {"UINT8": (8, False), "UINT16": (16, False), "UINT32": (32, False), "UINT64": (64, False)}
SCALARS |= {"INT8": (8, True), "INT16": (16, True), "INT32": (32, True), "INT64": (64, True)}
REALS = {"FLOAT": 32, "DOUBLE": 64}
OPEN_WORDS = "words_"  # Prefix of the names of enumerated types that do not have a word for every number.
TEXT_MAX_BITS = 8 * 4096
P_FIELD, CUC_FRACTION = 0x1F, 2.0**-24


def element(tag, *children, **attributes):
    """An element with children; text is its content, None is left out."""
    made = ET.Element(tag, {name: str(value) for name, value in attributes.items() if value is not None})
    for child in children:
        if isinstance(child, str):
            made.text = child
        elif child is not None:
            made.append(child)
    return made


def aliases(alias, space="type"):
    """Another name of an element; None if there is none."""
    return None if alias is None else element("AliasSet", element("Alias", nameSpace=space, alias=alias))


class System:
    """One space system; its sets are filled in any order and written in the order of the schema."""

    def __init__(self, name, parent=None, description=None):
        self.name, self.parent, self.description = name, parent, description
        self.path = f"{parent.path if parent else ''}/{name}"
        self.types = {"Parameter": {}, "Argument": {}}
        self.enumerations = {}  # Enumerations of the subsystem's descriptor: name -> {word: number}.
        self.parameters, self.containers, self.commands, self.children, self.algorithms = {}, [], [], [], []
        if parent:
            parent.children.append(self)

    @property
    def root(self):
        return self.parent.root if self.parent else self

    def type(self, what, name, make):
        """Path of a type, which `make(name)` creates on first use."""
        if name not in self.types[what]:
            self.types[what][name] = make(name)
        return f"{self.path}/{name}"

    def parameter(self, name, type_path, description=None, alias=None, data_source=None):
        """Path of a parameter, created on first use; data_source: where its values come from, if not from packets."""
        if name not in self.parameters:
            properties = element("ParameterProperties", dataSource=data_source) if data_source else None
            self.parameters[name] = element(
                "Parameter", aliases(alias, "id"), properties, name=name, parameterTypeRef=type_path, shortDescription=description
            )
        return f"{self.path}/{name}"

    def tree(self):
        """The element of the system and all in it."""
        made = element("SpaceSystem", name=self.name, shortDescription=self.description)
        telemetry = element("TelemetryMetaData")
        for tag, members in (
            ("ParameterTypeSet", self.types["Parameter"].values()),
            ("ParameterSet", self.parameters.values()),
            ("ContainerSet", self.containers),
            ("AlgorithmSet", self.algorithms),
        ):
            if members:
                telemetry.append(element(tag, *members))
        made.append(telemetry)
        if self.commands:
            arguments = self.types["Argument"].values()
            made.append(
                element(
                    "CommandMetaData",
                    element("ArgumentTypeSet", *arguments) if arguments else None,
                    element("MetaCommandSet", *self.commands),
                )
            )
        for child in self.children:
            made.append(child.tree())
        return made


# ---- encodings ----


def _integer_encoding(bits, signed=False, calibrator=None):
    coding = "twosComplement" if signed else "unsigned"
    return element("IntegerDataEncoding", calibrator, sizeInBits=bits, encoding=coding)


def _scaled(bits, coefficient):
    """Signed binary fraction: the integer in the packet is multiplied by `coefficient`."""
    term = element("Term", coefficient=repr(coefficient), exponent="1")
    polynomial = element("PolynomialCalibrator", element("Term", coefficient="0", exponent="0"), term)
    return _integer_encoding(bits, True, element("DefaultCalibrator", polynomial))


def reference(path):
    """Reference to a parameter by its raw value."""
    return element("ParameterInstanceRef", parameterRef=path, useCalibratedValue="false")


def dynamic(instance, intercept, slope=1):
    """A number that is computed from another field: slope * value + intercept."""
    return element("DynamicValue", instance, element("LinearAdjustment", intercept=intercept, slope=slope))


def _unit(unit):
    return element("UnitSet", element("Unit", unit)) if unit else None


def _range(what, low, high):
    """Limits: the ground refuses an argument that is outside, and warns if a parameter is outside."""
    if low is None and high is None:
        return None
    if what == "Argument":
        valid = element("ValidRange", minInclusive=low, maxInclusive=high)
        return element("ValidRangeSet", valid)
    warning = element("WarningRange", minInclusive=low, maxInclusive=high)
    return element("DefaultAlarm", element("StaticAlarmRanges", warning))


# ---- types ----


def integer(what, name, bits, signed=False, unit="", low=None, high=None):
    """Integer of up to 64 bits."""
    low, high = (None if low is None else int(low)), (None if high is None else int(high))
    return element(
        f"Integer{what}Type", _unit(unit), _integer_encoding(bits, signed), _range(what, low, high),
        name=name, signed=str(signed).lower(), sizeInBits=64 if bits > 32 else 32,
    )


def real(what, name, bits, unit="", low=None, high=None):
    """IEEE 754 number."""
    encoding = element("FloatDataEncoding", sizeInBits=bits, encoding="IEEE754_1985")
    return element(f"Float{what}Type", _unit(unit), encoding, _range(what, low, high), name=name, sizeInBits=bits)


def fraction(what, name, bits, exponent, unit):
    """Real number as a multiple of 2^-exponent; an argument is the integer multiple, because Yamcs 5.13 encodes
    negative reals as 0 there."""
    if what == "Argument":
        return integer(what, name, bits, True, f"2^-{exponent} {unit}")
    coefficient = 2.0**-exponent
    return element(f"Float{what}Type", _unit(unit), _scaled(bits, coefficient), name=name, sizeInBits=64)


def unit_word(text):
    """A unit as a part of the name of a type."""
    return _word(text)


def boolean(what, name, bits=8):
    """0 or 1, by default of one octet."""
    return element(f"Boolean{what}Type", _integer_encoding(bits), name=name)


def enumeration(what, name, words, bits, signed=False, unit=""):
    """Numbers with words."""
    listed = [element("Enumeration", value=number, label=word) for number, word in sorted((int(number), word) for number, word in words.items())]
    return element(f"Enumerated{what}Type", _unit(unit), _integer_encoding(bits, signed), element("EnumerationList", *listed), name=name)


def label(what, name, octets):
    """Text of a fixed size, padded with NUL."""
    size = element("SizeInBits", element("Fixed", element("FixedValue", str(8 * octets))), element("TerminationChar", "00"))
    return element(f"String{what}Type", element("StringDataEncoding", size, encoding="US-ASCII"), name=name)


def text_of(name, length):
    """Text of `length` octets; `length` is a parameter."""
    variable = element("Variable", dynamic(reference(length), 0, 8), maxSizeInBits=TEXT_MAX_BITS)
    return element("StringParameterType", element("StringDataEncoding", variable, encoding="US-ASCII"), name=name)


def text(what, name):
    """Text that follows its length [octets]. Yamcs ignores the reference, which the schema requires."""
    nothing = element("DynamicValue", element("ParameterInstanceRef", parameterRef="_yamcs_ignore"))
    variable = element(
        "Variable", nothing, element("LeadingSize", sizeInBitsOfSizeTag="16"), maxSizeInBits=TEXT_MAX_BITS
    )
    return element(f"String{what}Type", element("StringDataEncoding", variable, encoding="US-ASCII"), name=name)


def binary(what, name, octets):
    """Octets: a fixed number, or for an argument (-1) all octets of the value."""
    size = element("SizeInBits", element("FixedValue", str(8 * octets if octets >= 0 else -1)))
    return element(f"Binary{what}Type", element("BinaryDataEncoding", size), name=name)


def octets_of(name, length, intercept=0):
    """`length` + `intercept` octets; `length` is a parameter."""
    size = element("SizeInBits", dynamic(reference(length), 8 * intercept, 8))
    return element("BinaryParameterType", element("BinaryDataEncoding", size), name=name)


def octets(what, name):
    """Octets that follow their length; an algorithm of Yamcs reads and writes them."""
    direction, coder = ("From", "Decoder") if what == "Parameter" else ("To", "Encoder")
    algorithm = element("AlgorithmText", f"org.yamcs.algo.LeadingSizeBinary{coder}(16)", language="Java")
    transform = element(f"{direction}BinaryTransformAlgorithm", algorithm, name="leading_size")
    size = element("SizeInBits", element("FixedValue", "-1"))
    return element(f"Binary{what}Type", element("BinaryDataEncoding", size, transform), name=name)


def cuc_time(what, name):
    """Absolute time, CUC 4+3: with its P-field a number of 64 bits in units of 2^-24 s, whose zero lies before
    the epoch by the value of the P-field."""
    encoding = element(
        "Encoding", _integer_encoding(64), units="seconds", scale=repr(CUC_FRACTION), offset=-P_FIELD * 2**32
    )
    epoch = element("ReferenceTime", element("Epoch", "TAI"))
    return element(f"AbsoluteTime{what}Type", encoding, epoch, name=name)


def aggregate(what, name, members):
    """Structure. `members` are (name, path of the type), optionally with a description."""
    listed = [
        element("Member", name=member, typeRef=path, shortDescription=" ".join(words) or None) for member, path, *words in members
    ]
    return element(f"Aggregate{what}Type", element("MemberList", *listed), name=name)


def array(what, name, item, size):
    """Array of a fixed size, or of the size that the parameter or argument `size` contains."""
    if isinstance(size, int):
        end = element("FixedValue", str(size - 1))
    elif what == "Parameter":
        end = dynamic(reference(size), -1)
    else:
        end = dynamic(element("ArgumentInstanceRef", argumentRef=size), -1)
    start = element("StartingIndex", element("FixedValue", "0"))
    dimensions = element("DimensionList", element("Dimension", start, element("EndingIndex", end)))
    return element(f"Array{what}Type", dimensions, name=name, arrayTypeRef=item)


def scalar(root, what, kind, unit="", low=None, high=None, own=None):
    """Path of the type of a scalar of the descriptors; a type with a range is created as `own` (system, name)."""
    plain = own is None or (low is None and high is None)
    system, name = (root, kind if not unit else f"{kind}_{_word(unit)}") if plain else own

    def make(name):
        if kind == "BOOL":
            return boolean(what, name)
        if kind in REALS:
            return real(what, name, REALS[kind], unit, low, high)
        return integer(what, name, *SCALARS[kind], unit, low, high)

    return system.type(what, name, make)


def _word(text):
    return "".join(c if c.isalnum() else "_" for c in text)


def _bits_type(root, what, kind, about):
    """Path of the type of a number whose bits have names: an aggregate of the flags, from the highest bit, and of the state, whose bits are
    the lowest; each combination of these bits has the word of its state."""
    low, (width, _) = about["state_bits"], SCALARS[kind]
    words = {number: next((name for mask, value, name in about["states"] if number & mask == value), "UNKNOWN") for number in range(1 << low)}
    state = root.type(what, f"{about['name']}_state", lambda made: enumeration(what, made, words, low))
    flag = root.type(what, "flag", lambda made: boolean(what, made, 1))
    flags = [(about["flags"][str(bit)], flag, f"Bit {bit}") for bit in range(width - 1, low - 1, -1)]
    return root.type(what, about["name"], lambda made: aggregate(what, made, [*flags, ("STATE", state, f"Bits {low - 1} to 0")]))


def field_type(system, what, owner, field):
    """Path of the type of a field of the descriptors: name, type, count, unit, min, max, enumeration; and what the ground
    shows of it: quantity or kind, words, warning."""
    name = f"{owner}_{field['name']}" if owner else field["name"]
    kind, unit = field["type"], field["unit"] or field.get("quantity") or field.get("kind", "")
    if "enumeration" in field:
        words = {number: word for word, number in system.enumerations[field["enumeration"]].items()}
        own = f"{field['enumeration']}_{kind}_enumeration" + (f"_{_word(field['unit'])}" if field["unit"] else "")
        item = system.type(what, own, lambda made: enumeration(what, made, words, *SCALARS[kind], field["unit"]))
    elif field.get("kind") == "character":
        return system.root.type(what, f"label_{field['count']}", lambda made: label(what, made, field["count"]))
    elif "bits" in field:
        item = _bits_type(system.root, what, kind, field["bits"])
    elif "words" in field:
        words = field["words"]
        item = system.root.type(
            what, f"{OPEN_WORDS}{words['name']}_{kind}", lambda made: enumeration(what, made, words["numbers"], *SCALARS[kind])
        )
    else:
        limits = (None, None) if kind == "BOOL" else (field.get("min"), field.get("max"))
        if what == "Parameter" and "warning" in field:
            limits = (limits[0], field["warning"])
        item = scalar(system.root, what, kind, unit, *limits, own=(system, f"{name}_item"))
    if field["count"] == 1:
        return item
    return system.type(what, f"{name}_array", lambda made: array(what, made, item, field["count"]))
