"""Results: what computations return. Fields are declared once, in `record`; files, labelled arrays and tables follow."""
