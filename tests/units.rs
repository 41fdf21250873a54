//! Units as simulation tools see them: the functions of the interface, called in this process.
#![allow(unsafe_code, reason = "a C interface is made of pointers")]

mod calls;
mod interface;
mod judgement;
mod model_exchange;
mod states;
mod values;
