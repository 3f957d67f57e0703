"""What runs plants and controllers: simulation, metrics, studies, tables, figures, the command line."""
