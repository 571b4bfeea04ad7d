"""Values of literals, constant expressions and initial values."""
