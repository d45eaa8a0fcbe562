//! Frames, rotations, planes.
