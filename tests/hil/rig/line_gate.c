// A QEMU plug-in that stops the guest at each change of a line, so that the host can look at that instant.
//
//   -plugin line_gate.so,socket=PATH
//
// After each write to the levels or directions of the PL061 of QEMU's machine "virt" the emulated processor stops, sends
// "<offset in the PL061, hexadecimal>\n" over the socket and waits for one byte, which the host sends after looking and setting its
// lines. QEMU ends if the byte does not come, since unwatched lines would test nothing.

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

// The part of QEMU's plug-in interface that is used, version 1 (QEMU 4.2 to 8.1; Debian's packages come without the header).
typedef uint64_t qemu_plugin_id_t;
typedef uint32_t qemu_plugin_meminfo_t;
typedef struct qemu_info_t {
  const char* target_name;
  // What follows is not used.
} qemu_info_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
struct qemu_plugin_hwaddr;
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };
enum qemu_plugin_mem_rw { QEMU_PLUGIN_MEM_W = 2 };
typedef void (*qemu_plugin_vcpu_tb_trans_cb_t)(qemu_plugin_id_t id, struct qemu_plugin_tb* block);
typedef void (*qemu_plugin_vcpu_mem_cb_t)(unsigned cpu, qemu_plugin_meminfo_t info, uint64_t address, void* data);
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id, qemu_plugin_vcpu_tb_trans_cb_t callback);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* block, size_t index);
const void* qemu_plugin_insn_data(const struct qemu_plugin_insn* instruction);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn* instruction);
void qemu_plugin_register_vcpu_mem_cb(struct qemu_plugin_insn* instruction, qemu_plugin_vcpu_mem_cb_t callback,
                                      enum qemu_plugin_cb_flags flags, enum qemu_plugin_mem_rw access, void* data);
struct qemu_plugin_hwaddr* qemu_plugin_get_hwaddr(qemu_plugin_meminfo_t info, uint64_t address);
bool qemu_plugin_hwaddr_is_io(const struct qemu_plugin_hwaddr* address);
uint64_t qemu_plugin_hwaddr_phys_addr(const struct qemu_plugin_hwaddr* address);

#define EXPORT __attribute__((visibility("default")))
EXPORT extern const int qemu_plugin_version;
const int qemu_plugin_version = 1;

enum {
  kPl061 = 0x09030000,
  kDirections = 0x400,  // GPIODIR; below it is GPIODATA, once for each set of lines
};

static int host = -1;
static bool is_64_bit;

static void ask_host(uint64_t offset) {
  char question[16];
  const int length = snprintf(question, sizeof question, "%03x\n", (unsigned)offset);
  char answer;
  if (write(host, question, (size_t)length) != length || read(host, &answer, 1) != 1) {
    fputs("line_gate: the host has gone\n", stderr);
    exit(1);
  }
}

static void written(unsigned cpu, qemu_plugin_meminfo_t info, uint64_t address, void* data) {
  (void)cpu;
  (void)data;
  const struct qemu_plugin_hwaddr* const place = qemu_plugin_get_hwaddr(info, address);
  if (place == NULL || !qemu_plugin_hwaddr_is_io(place)) return;
  const uint64_t physical = qemu_plugin_hwaddr_phys_addr(place);
  if (physical >= kPl061 && physical <= kPl061 + kDirections) ask_host(physical - kPl061);
}

/// The driver writes bytes. Ignoring all other stores makes the guest several times as fast.
static bool stores_byte(const struct qemu_plugin_insn* instruction) {
  uint32_t code;
  if (qemu_plugin_insn_size(instruction) != sizeof code) return false;
  memcpy(&code, qemu_plugin_insn_data(instruction), sizeof code);
  if (is_64_bit) return (code & 0xffc00000) == 0x39000000;  // STRB (immediate, unsigned offset)
  return (code & 0x0c500000) == 0x04400000;                 // STRB (immediate or register)
}

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  const size_t count = qemu_plugin_tb_n_insns(block);
  for (size_t i = 0; i < count; ++i) {
    struct qemu_plugin_insn* const instruction = qemu_plugin_tb_get_insn(block, i);
    if (!stores_byte(instruction)) continue;
    qemu_plugin_register_vcpu_mem_cb(instruction, written, QEMU_PLUGIN_CB_NO_REGS, QEMU_PLUGIN_MEM_W, NULL);
  }
}

EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int count, char** arguments);
int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int count, char** arguments) {
  is_64_bit = strcmp(info->target_name, "aarch64") == 0;
  static const char kOption[] = "socket=";
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  for (int i = 0; i < count; ++i) {
    if (strncmp(arguments[i], kOption, sizeof kOption - 1) != 0) continue;
    const char* const path = arguments[i] + sizeof kOption - 1;
    if (strlen(path) < sizeof address.sun_path) strcpy(address.sun_path, path);
  }
  host = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (host < 0 || connect(host, (const struct sockaddr*)&address, sizeof address) != 0) {
    perror("line_gate: socket=PATH");
    return 1;
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  return 0;
}
