"""The words and signs of Structured Text that mean something to the parser.

Source: IEC 61131-3 (2013) tables 71 and 72; further words as in TwinCAT 3.
"""


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


SIGNS = _words(":= => <= >= <> .. ** - + * / = < > ( ) [ ] , ; : . & ^")

SECTIONS = _words(
    """VAR VAR_INPUT VAR_OUTPUT VAR_IN_OUT VAR_TEMP VAR_STAT VAR_INST VAR_EXTERNAL VAR_GLOBAL
    VAR_CONFIG VAR_GENERIC"""
)
"""Words that begin a block of variables."""

BLOCK_WORDS = SECTIONS | _words(
    """
    ACTION END_ACTION END_FUNCTION END_FUNCTION_BLOCK END_GET END_INTERFACE END_METHOD
    END_NAMESPACE END_PROGRAM END_PROPERTY END_SET END_TYPE END_VAR FUNCTION FUNCTION_BLOCK
    INTERFACE METHOD PROGRAM PROPERTY TYPE
    """
)
"""Words that begin or end a block, whatever was wrong before them."""

STATEMENT_WORDS = _words("CASE CONTINUE EXIT FOR IF JMP REPEAT RETURN WHILE __TRY")
"""Words that begin a statement."""

INNER_ENDS = _words(
    """ELSE ELSIF END_CASE END_FOR END_IF END_REPEAT END_WHILE UNTIL __CATCH __ENDTRY __FINALLY"""
)
"""Words that end the statements inside a statement."""

KEYWORDS = (
    BLOCK_WORDS
    | STATEMENT_WORDS
    | INNER_ENDS
    | _words(
        """
        AND AND_THEN ARRAY AT BY DO END_STRUCT END_UNION EXTENDS IMPLEMENTS MOD NOT OF OR OR_ELSE
        POINTER REFERENCE STRING STRUCT SUPER THEN THIS TO UNION WSTRING XOR
        """
    )
)
"""Words that are not names anywhere. Others (PUBLIC, CONSTANT, GET) mean something in their place
and are names elsewhere."""

ACCESS = _words("PUBLIC PRIVATE PROTECTED INTERNAL")
MODIFIERS = ACCESS | _words("ABSTRACT FINAL OVERRIDE")
"""Words that may precede the name of a unit or method."""
QUALIFIERS = ACCESS | _words("CONSTANT RETAIN NON_RETAIN PERSISTENT")
"""Words that may follow the word that begins a block of variables."""
