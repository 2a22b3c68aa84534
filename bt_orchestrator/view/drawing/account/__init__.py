"""The account of a period as one page of HTML, for the screen and for paper."""
