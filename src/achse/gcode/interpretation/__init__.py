"""Running a part program: blocks in, canonical commands out.

`interpreter` goes from block to block and `flow` jumps; `preparation` sorts the words of a block,
`block_words` carries them out, `moves` makes motion of them. `search` begins in the middle,
`checking` runs without a machine.
"""
