# SPDX-License-Identifier: Apache-2.0
"""The reader of descriptors: numbers, attributes, structure, hashes; each refusal has file, line and what is expected."""

import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "gse" / "generator"))

import catalogue
import descriptions
import source
from source import NUMBER_OUT_OF_RANGE, DescriptorError, Element

TABLE = {("", "Top"): "name!", ("Top", "Item"): "name! id size", ("Item", "Part"): ""}


def read(tmp_path, text):
    path = tmp_path / "d.xml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return source.read(path, TABLE, "Top")


def element(**attributes):
    return Element("d.xml", 7, "Item", attributes)


@pytest.mark.parametrize("text, value", [("0", 0), ("18446744073709551615", 2**64 - 1), ("18446744073709551616", None), ("0xFf", 255),
                                         ("-1", None), ("-0", None), ("1.0", None), ("", None), ("0x", None), ("1 ", None)])
def test_unsigned_numbers_are_read_or_refused(text, value):
    assert source.read_unsigned(text) == value


@pytest.mark.parametrize("text, kind, value", [
    ("255", "UINT8", 255), ("256", "UINT8", NUMBER_OUT_OF_RANGE), ("-0", "UINT8", NUMBER_OUT_OF_RANGE), ("-1", "UINT8", NUMBER_OUT_OF_RANGE),
    ("-128", "INT8", -128), ("-129", "INT8", NUMBER_OUT_OF_RANGE), ("127", "INT8", 127), ("128", "INT8", NUMBER_OUT_OF_RANGE),
    ("-9223372036854775808", "INT64", -(2**63)), ("9223372036854775808", "INT64", NUMBER_OUT_OF_RANGE), ("0x10", "INT16", 16), ("1.5", "INT16", None),
    ("true", "BOOL", 1), ("0", "BOOL", 0), ("yes", "BOOL", None),
    ("1.5", "DOUBLE", 1.5), ("-2e3", "FLOAT", -2000.0), ("1.", "DOUBLE", None), ("nan", "DOUBLE", None), ("1e400", "DOUBLE", NUMBER_OUT_OF_RANGE),
    ("3.5e38", "FLOAT", NUMBER_OUT_OF_RANGE), ("3.4e22", "FLOAT", 3.4e22), ("0.0000", "DOUBLE", 0.0),
    ("123456789012345", "DOUBLE", 123456789012345.0), ("1234567890123456", "DOUBLE", NUMBER_OUT_OF_RANGE),  # 15 digits are exact.
    ("1e22", "DOUBLE", 1e22), ("1e23", "DOUBLE", NUMBER_OUT_OF_RANGE), ("1e-22", "DOUBLE", 1e-22), ("1e-23", "DOUBLE", NUMBER_OUT_OF_RANGE)])
def test_numbers_of_a_type_are_read_or_refused(text, kind, value):
    assert source.read_number(text, kind) == value


@pytest.mark.parametrize("text, value", [("500us", 500), ("2ms", 2000), ("1s", 1000000), ("10s", 10000000)])
def test_times_are_read_in_microseconds(text, value):
    assert element(t=text).time_us("t", 500, 10_000_000) == value


@pytest.mark.parametrize("text", ["499us", "11s", "1", "1 s", "-1s", "1.5s", "1m"])
def test_other_times_are_refused(text):
    with pytest.raises(DescriptorError, match=rf't="{text}" of <Item>: expected a time like 500us, 2ms or 1s, from 500us to 10000000us'):
        element(t=text).time_us("t", 500, 10_000_000)


@pytest.mark.parametrize("ask, expected", [
    (lambda e: e.identifier(), "an upper-case identifier (A-Z 0-9 _) of at most 32 characters"),
    (lambda e: e.unsigned("number", 1, 9), "a number from 1 to 9"),
    (lambda e: e.flag("flag"), "true or false"),
    (lambda e: e.word("word", ["A", "B"]), "one of A B"),
    (lambda e: e.words("words", ["A", "B"]), "one or more words, each once, separated by single spaces, of A B"),
    (lambda e: e.lower_identifier("lower"), "a lower-case identifier (a-z 0-9 _ -) of at most 32 characters")])
def test_a_wrong_value_is_refused_with_what_is_expected(ask, expected):
    with pytest.raises(DescriptorError) as refused:
        ask(element(name="a", number="10", flag="1", word="C", words="A A", lower="Bus"))
    assert str(refused.value).startswith("d.xml:7: ") and str(refused.value).endswith(f"of <Item>: expected {expected}")


def test_values_that_are_not_given_have_their_defaults():
    none = element()
    assert (none.unsigned("a", 1, 2, 5), none.time_us("a", 1, 2, 6), none.flag("a", True), none.word("a", ["B"], "C")) == (5, 6, True, "C")


def test_ids_are_compared_as_numbers_and_names_as_text():
    first, second = element(name="A", id="16"), Element("d.xml", 9, "Item", {"name": "B", "id": "0x10"})
    source.unique([first, second], "name")
    with pytest.raises(DescriptorError, match=r'd.xml:9: id="0x10" of <Item> is taken in line 7'):
        source.unique([first, second], "name", "id")


@pytest.mark.parametrize("text, line, message", [
    ("<Other name='a'/>", 1, "<Other>: expected <Top>"),
    ("<Top name='a'>\n<Part/></Top>", 2, "<Part> in <Top>: expected one of Item"),
    ("<Top name='a'><Item name='b'><Part><Item/></Part></Item></Top>", 1, "<Item> in <Part>: expected nothing"),
    ("<Top/>", 1, "<Top> needs attribute name"),
    ("<Top name='a'>\n\n<Item name='b' color='c'/></Top>", 3, "attribute color of <Item>: expected one of name id size"),
    ("<Top name='a'><Item name='b'><Part size='1'/></Item></Top>", 1, "attribute size of <Part>: expected none"),
    ("<Top name='a'> x </Top>", 1, 'text "x" between elements: expected none'),
    ("<!DOCTYPE Top><Top name='a'/>", 1, "document type declarations are not allowed"),
    ("<?xml version='1.1'?><Top name='a'/>", 1, None),
    ("<?xml version='1.0' encoding='UTF-16'?><Top name='a'/>", 1, None),
    ("<Top name='a'>\n</Item>", 2, "not well-formed: mismatched tag"),
    (b"<Top name='\xff'/>", 1, "not well-formed: not well-formed (invalid token)"),
    (b"<!--" + bytes((32,)) * (1 << 20) + b"--><Top name='a'/>", 0, "octets, at most 1048576")])
def test_a_file_that_is_no_descriptor_is_refused_with_the_line(tmp_path, text, line, message):
    with pytest.raises(DescriptorError) as refused:
        read(tmp_path, text)
    assert str(refused.value).startswith(f"{tmp_path}/d.xml:{line}: ")
    assert message is None or str(refused.value).endswith(message)


def test_text_that_is_not_utf_8_is_refused_with_its_line(tmp_path):
    """So are the files of the catalogue and of the descriptions."""
    path = tmp_path / "descriptions.txt"
    path.write_bytes(b"# one\n# 20 \xb0C\n")
    for read_text in (source.text_of, descriptions.load, catalogue.Reader):
        with pytest.raises(DescriptorError, match="descriptions.txt:2: found octet 0xB0, expected UTF-8: convert the file"):
            read_text(path)


def test_a_file_that_is_missing_is_refused(tmp_path):
    with pytest.raises(DescriptorError, match=r"none.xml:0: cannot read: No such file"):
        source.read(tmp_path / "none.xml", TABLE, "Top")


def test_the_tree_has_elements_in_order_with_their_lines(tmp_path):
    top = read(tmp_path, "<Top name='a'>\n<Item name='b'/>\n<!-- x --><Item name='c'><Part/></Item></Top>")
    assert [(child.line, child.text("name")) for child in top.all("Item")] == [(2, "b"), (3, "c")]
    assert top.first("Item").text("name") == "b" and top.first("Part") is None and top.children[1].children[0].name == "Part"


def test_the_canonical_text_depends_on_the_content_only(tmp_path):
    one = read(tmp_path, "<Top name='a'><Item size='1' name='b'/></Top>")
    same = read(tmp_path, "<Top\n name='a'>  <!-- x -->\n<Item name='b' size='1'></Item></Top>")
    other = read(tmp_path, "<Top name='a'><Item size='2' name='b'/></Top>")
    assert source.canonical(one) == source.canonical(same) == "<Top\nname=a\n<Item\nname=b\nsize=1\n>\n>\n"
    assert source.canonical(one) != source.canonical(other)


def test_the_hash_is_fnv_1a():
    """The test vectors are those of the authors of FNV-1a."""
    assert source.fnv64(b"") == 0xCBF29CE484222325
    assert source.fnv64(b"a") == 0xAF63DC4C8601EC8C
    assert source.fnv64(b"foobar") == 0x85944171F73967E8
    assert source.fnv64(b"bar", source.fnv64(b"foo")) == source.fnv64(b"foobar")
