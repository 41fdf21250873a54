//! A scene that uses every function and every kind of load and output.
#![cfg(feature = "generate")]

include!(concat!(env!("OUT_DIR"), "/scenes.rs"));
