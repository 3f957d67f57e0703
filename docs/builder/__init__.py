"""What the site has beside Markdown: equations as MathML, and the pages of docs/made, made of the program itself."""
