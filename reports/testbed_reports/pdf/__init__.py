"""The report as a PDF: the page's model laid out in blocks, typeset by typst with fonts that wheels bring."""
