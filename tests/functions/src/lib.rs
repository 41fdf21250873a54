//! Scenes that use every function, every kind of load and output, and time wherever it may stand.

include!(concat!(env!("OUT_DIR"), "/scenes.rs"));
