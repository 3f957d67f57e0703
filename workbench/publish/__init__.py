"""What all results are published with: folders, tables, figures, pages, words."""
