"""Section 15 of the base language: the text of a program, and its image (.smx)."""

from hypothesis import given, settings
from hypothesis import strategies as st

from axistwin.controllers.smartmotor.language.image import Decoder, encode, labels, strip, sums

SOURCE = """\
   a=1          ' the start
C5
  WHILE a<3     ' count
    a=a+1
  LOOP
  IF a==3
    RETURN
  ELSE

    END
  ENDIF
"""
# places: 0 a=1, 4 C5, 7 WHILE a<3, 17 a=a+1, 23 LOOP, 28 IF a==3, 36 RETURN, 43 ELSE, 48 END, 52 ENDIF, 58 the end
TEXT = "a=1\nC5\nWHILE a<3\na=a+1\nLOOP\nIF a==3\nRETURN\nELSE\nEND\nENDIF\n"
WITH_JUMPS = "a=1\nC5\n$W001CLE a<3\na=a+1\n$L0007P\n$I0030 a==3\nRETURN\n$E003AE\nEND\nENDIF\n"


def decode(data):
    """Return the loaded text, and True if the sums in its header are right."""
    decoder = Decoder()
    decoder.feed(data)
    return decoder.result()


def test_comments_and_needless_blanks_are_not_kept():
    """15: the host strips comments and blanks before it downloads."""
    assert strip(SOURCE) == TEXT


def test_blanks_and_apostrophes_between_quotes_are_kept():
    assert strip('  PRINT("it\'s  so",#13)   \'a "comment"\r\n') == 'PRINT("it\'s  so",#13)\n'


def test_what_stands_on_one_line_stays_on_one_line():
    assert strip("ZS  MP\tA=100\raw[0]  1 2  3.\n") == "ZS MP A=100\naw[0] 1 2 3.\n"


def test_the_words_of_program_flow_contain_their_jumps():
    """WHILE jumps past LOOP, LOOP back to WHILE, IF past ELSE, ELSE past ENDIF; a place is a character of the text."""
    assert encode(TEXT).decode()[35:] == WITH_JUMPS


def test_the_header_has_labels_sum_length_and_the_label_addresses():
    """The header of TEXT: one label, C5 at place 4; 58 characters, whose codes add up to 3,500."""
    assert sum(ord(character) for character in TEXT) == 0xDAC
    assert encode(TEXT).decode()[:35] == "$4001000DAC00003A000004000000050004" and labels(TEXT) == {5: 4}


def test_the_sums_of_the_program_end():
    """RCKS of a program that is only END reports 0000E1: 45h + 4Eh + 44h + 0Ah."""
    assert sums("END\n") == (0, 0xE1)


def test_a_switch_goes_from_case_to_case_and_break_behind_its_end():
    text = "SWITCH a\nCASE 1\nBREAK\nCASE 2\nDEFAULT\nENDS\nEND\n"  # places of the words: 0, 9, 16, 22, 29, 37, 42
    assert encode(text).decode()[27:] == ("$S0009TCH a\n$C0016E 1\n$B002AAK\n$C001DE 2\n$D002AAULT\nENDS\nEND\n")


def test_elseif_is_tried_when_the_condition_before_it_is_false():
    text = "IF a\nb=1\nELSEIF c\nb=2\nENDIF\n"  # places of the words: 0, 5, 9, 18, 22, 28
    assert encode(text).decode()[27:] == "$I0009 a\nb=1\n$E001CEIF c\nb=2\nENDIF\n"


def test_words_without_their_counterpart_stay_as_they_are():
    for text in ("LOOP\nENDIF\n", "WHILE 1\nEND\n", "BREAK\nIF a\n", "IF a\nLOOP\nENDS\n", 'PRINT("IF LOOP")\n'):
        assert encode(text).decode()[27:] == text


def test_an_image_decodes_to_the_text_it_was_made_of():
    assert decode(encode(TEXT)) == (TEXT, True)
    assert decode(encode(TEXT) + b"\xff$a note of the compiler\0\x87\x00") == (TEXT, True)


def test_words_of_program_flow_are_understood_without_a_header_too():
    """Without a header IF is still recognised in $I003F, and WHILE in $W0059LE, as users have found them."""
    assert decode(b"$W0059LE 1\n$I003F a\nb=1\nENDIF\n$L0000P\n") == ("WHILE 1\nIF a\nb=1\nENDIF\nLOOP\n", True)


def test_a_header_of_later_firmware_is_understood():
    """A class 6 image has 25 digits after $6, among them the sum and the length; FF ends the text."""
    assert decode(b"$60000000E10000040000000000END\n\xff$end.smx\0") == ("END\n", True)


def test_a_damaged_image_is_found_out():
    image = encode(TEXT)
    assert decode(image.replace(b"a=a+1", b"a=a+2"))[1] is False and decode(image.removesuffix(b"ENDIF\n"))[1] is False


words = st.sampled_from(
    ["a=1", "IF a", "ELSE", "ELSEIF b", "ENDIF", "WHILE 1", "LOOP", "SWITCH c", "CASE 1", "DEFAULT", "ENDS", "BREAK",
     "C7", "C12", "GOSUB7", 'PRINT("IF $I0000 \'",#13)', "aw[0] 1 2."]
)  # fmt: skip


@settings(max_examples=50)
@given(st.lists(st.tuples(words, st.sampled_from(["\n", " ", "\r\n", " 'note\n"])), max_size=30))
def test_every_program_survives_its_image(parts):
    text = strip("".join(word + end for word, end in parts))
    assert strip(text) == text and decode(encode(text)) == (text, True)
    assert decode(text.encode()) == (text, True)


@given(st.binary(max_size=200))
def test_whatever_is_loaded_has_a_text(data):
    text, _ = decode(data)
    assert strip(text) == text
