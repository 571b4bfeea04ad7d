"""Laws by which an axis follows others, one module for each; `table` has them all."""
