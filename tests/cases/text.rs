//! Text files: comments, pragmas, encodings, forms of declarations, and what messages say.
