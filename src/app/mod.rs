//! The window: a second listener of a solve, beside the command line.
