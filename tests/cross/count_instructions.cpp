/// Plug-in for QEMU's user emulation that counts the instructions a program executes. tests/cross/counted_run.py builds it,
/// loads it with -plugin FILE,out=PATH, and reads what it writes to PATH when the program ends:
///
///     stderr COUNT     for each write(2) to standard error, in order: instructions so far
///     end COUNT THREADS
///
/// Debian has no header for QEMU's plug-ins (docs/devel/tcg-plugins.rst in its sources), so the used part of version 1 is declared here.

#include <array>
#include <cinttypes>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

using PluginId = std::uint64_t;
struct qemu_plugin_tb;  // a translated block: a run of instructions with one way in
enum class InlineOperation { kAddU64 };

// The first member of QEMU's qemu_info_t; the rest is not read.
struct TargetInfo {
  const char* target_name;
};

extern "C" {
void qemu_plugin_register_vcpu_init_cb(PluginId, void (*)(PluginId, unsigned));
void qemu_plugin_register_vcpu_tb_trans_cb(PluginId, void (*)(PluginId, qemu_plugin_tb*));
void qemu_plugin_register_vcpu_tb_exec_inline(qemu_plugin_tb*, InlineOperation, void* counter, std::uint64_t add);
std::size_t qemu_plugin_tb_n_insns(const qemu_plugin_tb*);
using SyscallCallback = void (*)(PluginId, unsigned, std::int64_t, std::uint64_t, std::uint64_t, std::uint64_t,
                                 std::uint64_t, std::uint64_t, std::uint64_t, std::uint64_t, std::uint64_t);
void qemu_plugin_register_vcpu_syscall_cb(PluginId, SyscallCallback);
void qemu_plugin_register_atexit_cb(PluginId, void (*)(PluginId, void*), void*);

[[gnu::visibility("default")]] extern const int qemu_plugin_version;
const int qemu_plugin_version = 1;
}

namespace {

/// An architecture, as QEMU calls it, and the number of its system call write.
struct Target {
  const char* name;
  std::int64_t write_number;
};

std::uint64_t executed = 0;
unsigned threads = 0;
std::int64_t write_number = 0;  ///< of the target's system call write
std::array<std::uint64_t, 1024> marks{};
std::size_t mark_count = 0;
std::string out;

void on_thread(PluginId /*id*/, unsigned /*index*/) { ++threads; }

void on_block(PluginId /*id*/, qemu_plugin_tb* block) {
  qemu_plugin_register_vcpu_tb_exec_inline(block, InlineOperation::kAddU64, &executed, qemu_plugin_tb_n_insns(block));
}

void on_call(PluginId /*id*/, unsigned /*index*/, std::int64_t number, std::uint64_t file, std::uint64_t /*a2*/,
             std::uint64_t /*a3*/, std::uint64_t /*a4*/, std::uint64_t /*a5*/, std::uint64_t /*a6*/,
             std::uint64_t /*a7*/, std::uint64_t /*a8*/) {
  constexpr std::uint64_t kStandardError = 2;
  if (number == write_number && file == kStandardError && mark_count < marks.size()) marks[mark_count++] = executed;
}

void on_exit(PluginId /*id*/, void* /*data*/) {
  std::FILE* const file = std::fopen(out.c_str(), "w");
  if (file == nullptr) return;  // the script reports that the file is missing
  for (std::size_t i = 0; i < mark_count; ++i) std::fprintf(file, "stderr %" PRIu64 "\n", marks[i]);
  std::fprintf(file, "end %" PRIu64 " %u\n", executed, threads);
  std::fclose(file);
}

}  // namespace

extern "C" [[gnu::visibility("default")]] int qemu_plugin_install(PluginId id, const TargetInfo* info, int argc,
                                                                  char** argv) {
  constexpr std::array<Target, 3> kTargets = {{{"arm", 4}, {"aarch64", 64}, {"x86_64", 1}}};
  for (const Target& target : kTargets) {
    if (std::strcmp(info->target_name, target.name) == 0) write_number = target.write_number;
  }
  if (argc != 1 || std::strncmp(argv[0], "out=", 4) != 0 || write_number == 0) return 1;
  out = argv[0] + 4;
  qemu_plugin_register_vcpu_init_cb(id, on_thread);
  qemu_plugin_register_vcpu_tb_trans_cb(id, on_block);
  qemu_plugin_register_vcpu_syscall_cb(id, on_call);
  qemu_plugin_register_atexit_cb(id, on_exit, nullptr);
  return 0;
}
