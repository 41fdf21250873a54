//! CUDA: the functions in C, in one header for code that runs on a device.

use super::Writer;
use crate::File;
use crate::ir::Program;
use crate::untranslated::Untranslated;

/// Writes a program as a header of CUDA, which compilers of C++ read too.
pub(crate) fn write_cuda(program: &Program) -> Result<Vec<File>, Untranslated> {
    let writer = Writer::new(program)?;
    let (name, guard) = (&program.name, program.name.to_uppercase());
    let code = qualified(&(writer.declarations()? + &writer.definitions()?), name);
    let head = format!("\n#ifndef {guard}_CUH\n#define {guard}_CUH\n");
    // Headers of several scenes define the same names for their own use.
    let begin = format!("namespace qrm_{name} {{\n\n");
    let end = format!("\n}}  // namespace qrm_{name}\n\nusing namespace qrm_{name};\n\n{UNDEFINED}\n#endif\n");
    let text = writer.introduction(USE) + &head + QUALIFIERS + &begin + &code + &end;
    Ok(vec![File { name: format!("{}.cuh", writer.stem()), text }])
}

/// The functions that the host calls too, for the parameters of a kernel.
const SHARED: [&str; 4] = ["constants", "default_parameters", "new", "parameters_with"];
/// The helpers that the shared functions call.
const HELPERS: [&str; 4] = ["maximum", "minimum", "number_or", "sign"];

/// Code with the qualifiers of CUDA: functions and tables begin without indentation.
pub(super) fn qualified(code: &str, name: &str) -> String {
    let shared: Vec<String> = SHARED.iter().map(|own| format!("{name}_{own}(")).collect();
    let helpers: Vec<String> = HELPERS.iter().map(|own| format!("double {own}(")).collect();
    let line = |line: &str| {
        let is_shared = shared.iter().chain(&helpers).any(|call| line.contains(call));
        let begins = |words: &[&str]| words.iter().any(|word| line.starts_with(word));
        let (qualifier, rest) = match line.strip_prefix("static ") {
            Some(rest) if rest.starts_with("const ") => ("QRM_TABLE ", rest),
            Some(rest) if is_shared => ("QRM_SHARED ", rest),
            Some(rest) => ("QRM_DEVICE ", rest),
            None if !begins(&["void ", "double ", "int ", "INLINE "]) => ("", line),
            None if is_shared => ("QRM_SHARED ", line),
            None => ("QRM_DEVICE ", line),
        };
        format!("{qualifier}{rest}\n")
    };
    code.lines().map(line).collect()
}

/// The qualifiers of functions and tables. The run-time compiler of CUDA has no headers of the host.
pub(super) const QUALIFIERS: &str = "
#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define QRM_DEVICE static __device__
#define QRM_SHARED static __host__ __device__
#define QRM_TABLE static __constant__
#else
#define QRM_DEVICE static
#define QRM_SHARED static
#define QRM_TABLE static
#endif
#define INLINE inline
#if defined(__CUDACC_RTC__)
#define DBL_MIN 2.2250738585072014e-308
#define INFINITY __longlong_as_double(0x7ff0000000000000)
#define NAN __longlong_as_double(0x7ff8000000000000)
#else
#include <float.h>
#include <math.h>
#endif

";

/// The macros that only a header needs.
const UNDEFINED: &str = "#undef INLINE\n#undef QRM_DEVICE\n#undef QRM_SHARED\n#undef QRM_TABLE\n";

/// An example of a kernel.
const USE: &str = "
// A motion of each thread, by parameters of its own, which the host takes from `scene_default_parameters`:
//
//     __global__ void run(const struct scene_parameters *p, struct scene_state *end, int count, double h, int steps)
//     {
//         const int i = blockIdx.x * blockDim.x + threadIdx.x;
//         struct scene mechanism;
//         struct scene_step step;
//         if (i >= count) {
//             return;
//         }
//         scene_new(&p[i], &mechanism);
//         if (!scene_initial_state(&mechanism, &step.end)) { the loops cannot be closed }
//         for (int k = 0; k < steps; k++) {
//             scene_rk4_step(&mechanism, k * h, h, &step.end, &step);
//         }
//         end[i] = step.end;
//     }
";
