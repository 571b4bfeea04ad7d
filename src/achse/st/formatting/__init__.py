"""The formatter: indentation and trailing blanks of Structured Text, and nothing else unless
options require it."""
