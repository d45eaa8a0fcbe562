//! Distributions, robust scale, seeded random streams.
