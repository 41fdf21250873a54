//! CUDA: the functions in C, in one header for code that runs on a device.

use super::Writer;
use crate::File;
use crate::ir::Program;
use crate::untranslated::Untranslated;

/// Writes a program as a header of CUDA, which compilers of C++ read too.
pub(crate) fn write_cuda(program: &Program) -> Result<Vec<File>, Untranslated> {
    let writer = Writer::new(program)?;
    let guard = program.name.to_uppercase();
    let code = writer.declarations()? + &writer.definitions()?;
    let code: String = code.lines().map(|line| qualified(line) + "\n").collect();
    let head = format!("\n#ifndef {guard}_CUH\n#define {guard}_CUH\n");
    let text = writer.introduction(USE) + &head + QUALIFIERS + &code + "\n#endif\n";
    Ok(vec![File { name: format!("{}.cuh", writer.stem()), text }])
}

/// A line with the qualifiers of CUDA: functions and tables begin without indentation.
pub(super) fn qualified(line: &str) -> String {
    let begins = |words: &[&str]| words.iter().any(|word| line.starts_with(word));
    match line.strip_prefix("static ") {
        Some(rest) if rest.starts_with("const ") => format!("TABLE {rest}"),
        Some(rest) => format!("DEVICE {rest}"),
        None if begins(&["void ", "double ", "int ", "INLINE "]) => format!("DEVICE {line}"),
        None => line.to_owned(),
    }
}

/// The qualifiers of functions and tables. The run-time compiler of CUDA has no headers of the host.
pub(super) const QUALIFIERS: &str = "
#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define DEVICE static __device__
#define TABLE static __constant__
#else
#define DEVICE static
#define TABLE static
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

/// An example of a kernel.
const USE: &str = "
// A motion of each thread, by parameters of its own:
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
