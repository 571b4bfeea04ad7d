"""Language Server Protocol: editors show what the checker finds, and what names mean.

Positions go between documents, as a client has them, and sources, where the code in the CDATA of
a file is one text. Answers come from a workspace that is kept between requests.
"""
