"""The text of a part program: its lines as blocks of words, formulas, labels and subroutines."""
