//! Error budgets: which error source costs how much of which parameter, by which path, and what survey would do better.
//!
//! | file | what |
//! |---|---|
