// The functions of the CUDA driver and of its run-time compiler that `qrm` calls, without a GPU: kernels are compiled by a
// compiler of C++ and run on a core. The variable FAILS names a function that fails.
//
//     g++ -shared -fPIC -o libcuda.so.1 driver.cpp && cp libcuda.so.1 libnvrtc.so.12

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <string>
#include <unistd.h>

namespace {

enum { NO_ERROR = 0, OUT_OF_MEMORY = 2, NO_DEVICE = 100, LAUNCH_FAILED = 719, NOT_SUPPORTED = 801, COMPILATION_FAILED = 6 };

// A program of the run-time compiler.
struct Program {
    std::string text, log, library;
};

bool fails(const char *name)
{
    const char *failing = std::getenv("FAILS");
    return failing && std::strcmp(failing, name) == 0;
}

}  // namespace

#define API(name) extern "C" int name
#define DOES_NOTHING(name, ...) API(name)(__VA_ARGS__) { return NO_ERROR; }

DOES_NOTHING(cuCtxSetCurrent, void *)
DOES_NOTHING(cuCtxSynchronize)
DOES_NOTHING(cuDevicePrimaryCtxRelease_v2, int)
DOES_NOTHING(cuEventDestroy_v2, void *)
DOES_NOTHING(cuEventRecord, void *, void *)
DOES_NOTHING(cuEventSynchronize, void *)
DOES_NOTHING(cuStreamDestroy_v2, void *)
DOES_NOTHING(cuStreamSynchronize, void *)
DOES_NOTHING(cuStreamWaitEvent, void *, void *, unsigned)

API(cuInit)(unsigned) { return fails("cuInit") ? NO_DEVICE : NO_ERROR; }

// The run-time compiler asks for it.
API(cuGetExportTable)(const void **, const void *) { return NOT_SUPPORTED; }

API(cuDeviceGet)(int *device, int ordinal)
{
    *device = ordinal;
    return NO_ERROR;
}

API(cuDeviceGetName)(char *name, int length, int)
{
    std::snprintf(name, length, "a core");
    return NO_ERROR;
}

API(cuDeviceGetAttribute)(int *value, int, int)
{
    *value = 0;
    return NO_ERROR;
}

API(cuDevicePrimaryCtxRetain)(void **context, int)
{
    *context = context;
    return NO_ERROR;
}

API(cuCtxGetCurrent)(void **context)
{
    *context = nullptr;
    return NO_ERROR;
}

API(cuStreamCreate)(void **stream, unsigned)
{
    *stream = stream;
    return NO_ERROR;
}

API(cuEventCreate)(void **event, unsigned)
{
    *event = event;
    return NO_ERROR;
}

API(cuMemAlloc_v2)(void **memory, size_t bytes)
{
    *memory = fails("cuMemAlloc") ? nullptr : std::malloc(bytes);
    return *memory ? NO_ERROR : OUT_OF_MEMORY;
}

API(cuMemFree_v2)(void *memory)
{
    std::free(memory);
    return NO_ERROR;
}

API(cuMemsetD8Async)(void *memory, unsigned char value, size_t count, void *)
{
    std::memset(memory, value, count);
    return NO_ERROR;
}

API(cuMemcpyHtoDAsync_v2)(void *to, const void *from, size_t bytes, void *)
{
    std::memcpy(to, from, bytes);
    return NO_ERROR;
}

API(cuMemcpyDtoHAsync_v2)(void *to, const void *from, size_t bytes, void *)
{
    std::memcpy(to, from, bytes);
    return NO_ERROR;
}

// The image of a module is the path of its library.
API(cuModuleLoadData)(void **module, const void *image)
{
    const std::string library = static_cast<const char *>(image);
    // Code for a real GPU.
    if (library[0] != '/') {
        return LAUNCH_FAILED;
    }
    *module = dlopen(library.c_str(), RTLD_NOW);
    std::remove(library.c_str());
    rmdir(library.substr(0, library.rfind('/')).c_str());
    return *module ? NO_ERROR : LAUNCH_FAILED;
}

API(cuModuleUnload)(void *module)
{
    dlclose(module);
    return NO_ERROR;
}

API(cuModuleGetFunction)(void **function, void *module, const char *name)
{
    *function = dlsym(module, name);
    return *function ? NO_ERROR : LAUNCH_FAILED;
}

API(cuLaunchKernel)(void *function, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, unsigned, void *,
                    void **arguments, void **)
{
    if (fails("cuLaunchKernel")) {
        return LAUNCH_FAILED;
    }
    const auto advance = reinterpret_cast<void (*)(double *, int)>(function);
    advance(*static_cast<double **>(arguments[0]), *static_cast<int *>(arguments[1]));
    return NO_ERROR;
}

API(cuGetErrorString)(int error, const char **text)
{
    *text = error == NO_DEVICE ? "no CUDA-capable device is detected" : "unspecified launch failure";
    return NO_ERROR;
}

API(cuGetErrorName)(int, const char **text)
{
    *text = "CUDA_ERROR";
    return NO_ERROR;
}

API(nvrtcCreateProgram)(Program **program, const char *text, const char *, int, const char *const *,
                        const char *const *)
{
    *program = new Program{text, "", ""};
    return NO_ERROR;
}

API(nvrtcCompileProgram)(Program *program, int, const char *const *)
{
    char folder[] = "/tmp/qrm-gpu-XXXXXX";
    if (fails("nvrtcCompileProgram") || !mkdtemp(folder)) {
        program->log = "a line of its log";
        return COMPILATION_FAILED;
    }
    const std::string source = std::string(folder) + "/steps.cpp";
    program->library = std::string(folder) + "/steps.so";
    std::FILE *file = std::fopen(source.c_str(), "w");
    if (!file) {
        return COMPILATION_FAILED;
    }
    std::fwrite(program->text.data(), 1, program->text.size(), file);
    std::fclose(file);
    const std::string warnings = "-Wall -Wextra -Werror -Wno-unused-function ";
    const std::string command = "g++ -std=c++17 -O1 -shared -fPIC " + warnings + source + " -o " + program->library;
    const bool is_compiled = std::system(command.c_str()) == 0;
    std::remove(source.c_str());
    return is_compiled ? NO_ERROR : COMPILATION_FAILED;
}

API(nvrtcGetPTXSize)(Program *program, size_t *size)
{
    *size = program->library.size() + 1;
    return NO_ERROR;
}

API(nvrtcGetPTX)(Program *program, char *image)
{
    std::strcpy(image, program->library.c_str());
    return NO_ERROR;
}

API(nvrtcGetProgramLogSize)(Program *program, size_t *size)
{
    *size = program->log.size() + 1;
    return NO_ERROR;
}

API(nvrtcGetProgramLog)(Program *program, char *log)
{
    std::strcpy(log, program->log.c_str());
    return NO_ERROR;
}

API(nvrtcDestroyProgram)(Program **program)
{
    delete *program;
    *program = nullptr;
    return NO_ERROR;
}
