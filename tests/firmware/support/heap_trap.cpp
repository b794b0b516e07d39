#include "tests/firmware/support/heap_trap.hpp"

#include <dlfcn.h>
#include <execinfo.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <string_view>

// The functions replaced below, under the C library's own names.
extern "C" {
void* real_malloc(std::size_t size) asm("__libc_malloc");
void* real_calloc(std::size_t count, std::size_t size) asm("__libc_calloc");
void* real_realloc(void* block, std::size_t size) asm("__libc_realloc");
void* real_memalign(std::size_t align, std::size_t size) asm("__libc_memalign");
}

namespace {

// Plain static objects without constructors: malloc is called before main, and in every thread.
constexpr int kFrames = 24;
constexpr int kMostStacks = 4;
std::atomic<bool> armed{false};
std::atomic<int> trapped{0};
std::atomic<int> from_simulator{0};
void* stacks[kMostStacks][kFrames];
int stack_sizes[kMostStacks];
thread_local bool in_trap = false;

/// A name of plumbline::hal::sim, a const member function's or another's.
bool is_simulator(std::string_view symbol) {
  return symbol.starts_with("_ZN9plumbline3hal3sim") || symbol.starts_with("_ZNK9plumbline3hal3sim");
}

bool is_of_simulator(void* const* stack, int frames) {
  return std::any_of(stack, stack + frames, [](void* frame) {
    Dl_info info = {};
    return dladdr(frame, &info) != 0 && info.dli_sname != nullptr && is_simulator(info.dli_sname);
  });
}

void* seen(void* block) {
  if (!armed.load(std::memory_order_relaxed) || in_trap || block == nullptr) return block;
  in_trap = true;
  void* stack[kFrames];
  const int frames = backtrace(stack, kFrames);
  if (is_of_simulator(stack, frames)) {
    ++from_simulator;
  } else if (const int n = trapped.fetch_add(1); n < kMostStacks) {
    std::copy_n(stack, frames, stacks[n]);
    stack_sizes[n] = frames;
  }
  in_trap = false;
  return block;
}

}  // namespace

// Only the linker sees the replaced names, so the compiler does not optimise these as malloc and free.
extern "C" {
void* trapped_malloc(std::size_t size) asm("malloc");
void* trapped_calloc(std::size_t count, std::size_t size) asm("calloc");
void* trapped_realloc(void* block, std::size_t size) asm("realloc");
void* trapped_memalign(std::size_t align, std::size_t size) asm("memalign");
void* trapped_aligned_alloc(std::size_t align, std::size_t size) asm("aligned_alloc");
int trapped_posix_memalign(void** block, std::size_t align, std::size_t size) asm("posix_memalign");

void* trapped_malloc(std::size_t size) { return seen(real_malloc(size)); }
void* trapped_calloc(std::size_t count, std::size_t size) { return seen(real_calloc(count, size)); }
void* trapped_realloc(void* block, std::size_t size) { return seen(real_realloc(block, size)); }
void* trapped_memalign(std::size_t align, std::size_t size) { return seen(real_memalign(align, size)); }
void* trapped_aligned_alloc(std::size_t align, std::size_t size) { return seen(real_memalign(align, size)); }
int trapped_posix_memalign(void** block, std::size_t align, std::size_t size) {
  *block = seen(real_memalign(align, size));
  return *block == nullptr ? ENOMEM : 0;
}
}

namespace plumbline::firmware {

HeapTrap::HeapTrap() {
  void* warm[kFrames];
  backtrace(warm, kFrames);  // its first call loads a library, which takes memory
  trapped = 0;
  from_simulator = 0;
  armed = true;
}

HeapUse HeapTrap::disarm() {
  armed = false;
  return {trapped, from_simulator};
}

void HeapTrap::print_stacks() {
  for (int i = 0; i < std::min(trapped.load(), kMostStacks); ++i) {
    backtrace_symbols_fd(stacks[i], stack_sizes[i], STDERR_FILENO);
    static_cast<void>(!write(STDERR_FILENO, "\n", 1));
  }
}

}  // namespace plumbline::firmware
