// Preloaded into torqued, tells who allocates: between SIGUSR1 and SIGUSR2 it counts what the main thread asks of
// malloc and its kin, by who asks — the nearest caller that is either the program itself or LCM; the C and C++
// libraries, fmt and spdlog allocate for whoever called them. SIGUSR2 writes the program's count, how many allocations
// of all kinds were seen since the start, and where the program allocated first, to the file that ALLOCATION_REPORT
// names.

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

extern "C"
{
  void* __libc_malloc(std::size_t size);
  void* __libc_calloc(std::size_t count, std::size_t size);
  void* __libc_realloc(void* memory, std::size_t size);
  void* __libc_memalign(std::size_t alignment, std::size_t size);
}

namespace
{

constexpr int kFrames = 64;

std::atomic<bool> counting{false};
std::atomic<long> by_program{0}, seen{0};
std::array<void*, kFrames> first_frames;
std::atomic<int> num_first_frames{0};
thread_local bool inside = false;

bool is_program(const Dl_info& module)
{
  char path[4096];
  const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1);
  path[std::max<ssize_t>(length, 0)] = '\0';
  return std::strcmp(module.dli_fname, path) == 0;
}

void note()
{
  ++seen;
  if (!counting || inside)
    return;
  inside = true;
  std::array<void*, kFrames> frames;
  const int count = backtrace(frames.data(), kFrames);
  for (int i = 0; i < count; ++i)
  {
    Dl_info module;
    if (dladdr(frames[static_cast<std::size_t>(i)], &module) == 0)
      continue;
    if (std::strstr(module.dli_fname, "/liblcm") != nullptr)
      break;
    if (is_program(module))
    {
      if (gettid() == getpid() && by_program++ == 0)
      {
        first_frames = frames;
        num_first_frames = count;
      }
      break;
    }
  }
  inside = false;
}

void report(int)
{
  counting = false;
  const char* path = std::getenv("ALLOCATION_REPORT");
  const int file = open(path == nullptr ? "/dev/stderr" : path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  dprintf(file, "program %ld seen %ld\n", by_program.load(), seen.load());
  backtrace_symbols_fd(first_frames.data(), num_first_frames, file);
  dprintf(file, "end\n");
  close(file);
}

__attribute__((constructor)) void begin()
{
  // the first backtrace() loads a library
  std::array<void*, 2> frames;
  backtrace(frames.data(), 2);
  signal(SIGUSR1, [](int) { counting = true; });
  signal(SIGUSR2, &report);
}

} // namespace

extern "C"
{
  void* malloc(std::size_t size)
  {
    note();
    return __libc_malloc(size);
  }
  void* calloc(std::size_t count, std::size_t size)
  {
    note();
    return __libc_calloc(count, size);
  }
  void* realloc(void* memory, std::size_t size)
  {
    note();
    return __libc_realloc(memory, size);
  }
  void* aligned_alloc(std::size_t alignment, std::size_t size)
  {
    note();
    return __libc_memalign(alignment, size);
  }
  int posix_memalign(void** memory, std::size_t alignment, std::size_t size)
  {
    note();
    *memory = __libc_memalign(alignment, size);
    return *memory == nullptr ? ENOMEM : 0;
  }
}
