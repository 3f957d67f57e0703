"""Text, units and tables as LaTeX shows them, in pdfLaTeX and LuaLaTeX alike."""
