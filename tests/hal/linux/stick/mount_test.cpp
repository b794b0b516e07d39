/// The real plumbline-mount. That it mounts real sticks is tested on the emulated board (tests/hil/rig).

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/mount.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/stick/mount_protocol.hpp"
#include "hal/linux/stick/stick_volume.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Mount : public testing::Test {
 protected:
  Mount() {
    std::string pattern = (std::filesystem::temp_directory_path() / "plumbline-mount-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
    socket_ = folder_ + "/socket";
    start();
  }
  ~Mount() override {
    end();
    std::filesystem::remove_all(folder_);
  }

  void start() {
    std::string program = PLUMBLINE_MOUNT;
    char* const arguments[] = {program.data(), socket_.data(), nullptr};
    ASSERT_EQ(::posix_spawn(&process_, program.c_str(), nullptr, nullptr, arguments, environ), 0);
    int connection = -1;
    for (int tries = 0; connection < 0 && tries < 1000; ++tries) {
      connection = connect_to_mount(socket_);
      if (connection < 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_GE(connection, 0);
    ::close(connection);
  }
  void end() const {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }

  /// The reply to a request.
  int ask(const std::string& device, std::span<const int> descriptors = {}) const {
    const int connection = connect_to_mount(socket_);
    EXPECT_GE(connection, 0);
    EXPECT_TRUE(send_message(connection, std::as_bytes(std::span(device)), descriptors));
    int reason = 0;
    const auto reply = receive_message(connection, std::as_writable_bytes(std::span(&reason, 1)));
    ::close(connection);
    EXPECT_TRUE(reply && reply->bytes == sizeof reason);
    EXPECT_TRUE(reply->descriptors().empty());
    return reason;
  }

  std::string folder_;
  std::string socket_;
  pid_t process_ = -1;
};

TEST_F(Mount, RefusesEveryDeviceThatIsNotOnTheUsbBus) {
  int seen = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/class/block")) {
    if (std::filesystem::read_symlink(entry.path()).string().find("/usb") != std::string::npos) continue;
    EXPECT_EQ(ask(entry.path().filename()), EACCES) << entry.path();
    ++seen;
  }
  if (seen == 0) GTEST_SKIP() << "this machine has no block device";
}

TEST_F(Mount, RefusesWhatIsNoDevicesName) {
  for (const std::string name : {"..", "../block/sda", "/dev/sda1", "sda 1", "sda\n", "nothing", "null", "sd*"}) {
    EXPECT_EQ(ask(name), EACCES) << name;
  }
  EXPECT_EQ(ask(std::string(kDeviceNameBytes, 'a')), EACCES);
  EXPECT_EQ(ask(std::string(5000, 'a')), EACCES);
  EXPECT_EQ(ask(std::string(1, '\0')), EACCES);
}

TEST_F(Mount, ServesTheNextAfterOneThatSaysNothingOrHasGoneOrSendsADescriptor) {
  const int silent = connect_to_mount(socket_);
  ::close(connect_to_mount(socket_));
  EXPECT_EQ(ask("nothing"), EACCES) << "after a second";
  ::close(silent);
  constexpr std::array kTwo = {STDIN_FILENO, STDIN_FILENO};
  for (int times = 0; times < 2000; ++times) ASSERT_EQ(ask("nothing", kTwo), EACCES) << "out of descriptors";
}

TEST_F(Mount, StoresNoReportOnWhatIsNoStick) {
  for (const char* device : {"nothing", "../sda1", ""}) {
    ReportRequest request;
    std::string_view(device).copy(request.device.data(), request.device.size() - 1);
    std::string_view("a.json").copy(request.name.data(), request.name.size() - 1);
    const std::string bytes(reinterpret_cast<const char*>(&request), sizeof request);
    constexpr std::array kOne = {STDIN_FILENO};
    constexpr std::array kTwo = {STDIN_FILENO, STDIN_FILENO};
    EXPECT_EQ(ask(bytes, kOne), EACCES);
    EXPECT_EQ(ask(bytes, kTwo), EACCES);
    EXPECT_EQ(ask(bytes), EACCES);
  }
  const std::string endless(sizeof(ReportRequest), 'a');
  EXPECT_EQ(ask(endless), EACCES);
  const auto refused = store_on_stick({"/dev/nothing1"}, {"a.json", STDIN_FILENO, 0, 1}, socket_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kCannotWrite);
}

TEST_F(Mount, ListensForItsOwnUserOnly) {
  struct stat facts {};
  ASSERT_EQ(::stat(socket_.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0600U);
}

TEST_F(Mount, StartsAgainAfterItWasKilled) {
  end();
  const auto gone = mount_stick({"/dev/sda1"}, socket_);
  ASSERT_FALSE(gone);
  EXPECT_THAT(gone.error().message(), HasSubstr("plumbline-mount does not answer (Connection refused)"));
  EXPECT_THAT(std::string(gone.error().advice()), HasSubstr("start plumbline-mount.service"));
  start();
  const auto refused = mount_stick({"/dev/nothing1", "/dev/nothing"}, socket_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), ErrorCode::kMountFailed);
  EXPECT_THAT(refused.error().message(), HasSubstr("/dev/nothing1: Permission denied"));
  EXPECT_THAT(mount_stick({}, socket_).error().message(), HasSubstr("no storage on the stick"));
}

/// plumbline-mount whose calls about sticks come to the test instead of the kernel (seccomp(2), SECCOMP_RET_USER_NOTIF): there is a stick
/// sda1, and each attempt to mount it fails with EPERM.
class MountCalls : public Mount {
 protected:
  MountCalls() {
    end();
    start_watched();
  }
  ~MountCalls() override {
    ::kill(process_, SIGKILL);
    stop();
    ::close(listener_);
  }
  /// No call is answered any more, so the records below stand.
  void stop() {
    quit_ = true;
    if (calls_.joinable()) calls_.join();
  }

  // Each as it came.
  std::vector<std::string> file_systems_, options_;
  std::vector<std::uint64_t> attributes_;

 private:
  static int install_filter() {
    std::vector<sock_filter> program{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
    for (const long call : {
#ifdef SYS_readlink
             long{SYS_readlink},
#endif
             long{SYS_readlinkat}, long{SYS_fsopen}, long{SYS_fsconfig}, long{SYS_fsmount}}) {
      program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1));
      program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_USER_NOTIF));
    }
    program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
    sock_fprog filter{};
    filter.len = static_cast<unsigned short>(program.size());
    filter.filter = program.data();
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return -1;
    return static_cast<int>(::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_NEW_LISTENER, &filter));
  }

  void start_watched() {
    std::array<int, 2> pair{};
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair.data()), 0);
    process_ = ::fork();
    if (process_ == 0) {
      const int listener = install_filter();
      const std::byte word{};
      if (listener < 0 || !send_message(pair[1], {&word, 1}, {&listener, 1})) ::_exit(77);
      ::close(listener);
      ::execl(PLUMBLINE_MOUNT, PLUMBLINE_MOUNT, socket_.c_str(), nullptr);
      ::_exit(78);
    }
    std::byte word{};
    const auto got = receive_message(pair[0], {&word, 1});
    for (const int fd : pair) ::close(fd);
    ASSERT_TRUE(got && got->descriptors().size() == 1) << "this kernel tells nobody of calls";
    listener_ = got->descriptors()[0];
    calls_ = std::thread([this] {
      while (!quit_) answer_next();
    });
    int connection = -1;
    for (int tries = 0; connection < 0 && tries < 2000; ++tries) {
      connection = connect_to_mount(socket_);
      if (connection < 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_GE(connection, 0);
    ::close(connection);
  }

  /// The text at an address of the process.
  std::string text_at(std::uint64_t address) const {
    std::array<char, 128> text{};
    const int memory = ::open(("/proc/" + std::to_string(process_) + "/mem").c_str(), O_RDONLY | O_CLOEXEC);
    if (address != 0 && ::pread(memory, text.data(), text.size() - 1, static_cast<off_t>(address)) <= 0) {
      ADD_FAILURE() << "the process's memory can't be read";
    }
    ::close(memory);
    return text.data();
  }
  long write_at(std::uint64_t address, std::string_view text) const {
    const int memory = ::open(("/proc/" + std::to_string(process_) + "/mem").c_str(), O_WRONLY | O_CLOEXEC);
    const long written = ::pwrite(memory, text.data(), text.size(), static_cast<off_t>(address));
    ::close(memory);
    return written;
  }

  void answer_next() {
    pollfd fd{listener_, POLLIN, 0};
    if (::poll(&fd, 1, 20) != 1) return;
    seccomp_notif call{};
    if (::ioctl(listener_, SECCOMP_IOCTL_NOTIF_RECV, &call) != 0) return;
    seccomp_notif_resp answer{};
    answer.id = call.id;
    const auto& arguments = call.data.args;
    switch (call.data.nr) {
      case SYS_fsopen:
        file_systems_.push_back(text_at(arguments[0]));
        answer.val = 1000;  // no process has it
        break;
      case SYS_fsconfig: {
        const std::string value = text_at(arguments[3]);
        if (arguments[2] != 0) options_.push_back(text_at(arguments[2]) + (value.empty() ? "" : "=" + value));
        break;
      }
      case SYS_fsmount:
        attributes_.push_back(arguments[2]);
        answer.error = -EPERM;
        break;
      default: {
#ifdef SYS_readlink
        const std::size_t path = call.data.nr == SYS_readlink ? 0 : 1;
#else
        constexpr std::size_t path = 1;
#endif
        if (text_at(arguments[path]) == "/sys/class/block/sda1") {
          answer.val = write_at(arguments[path + 1], "../../devices/pci0/usb1/1-1/1-1:1.0/host0/block/sda/sda1");
        } else {
          answer.flags = SECCOMP_USER_NOTIF_FLAG_CONTINUE;
        }
      }
    }
    static_cast<void>(::ioctl(listener_, SECCOMP_IOCTL_NOTIF_SEND, &answer));
  }

  int listener_ = -1;
  std::atomic<bool> quit_ = false;
  std::thread calls_;
};

constexpr std::uint64_t kSafe = MOUNT_ATTR_NOSUID | MOUNT_ATTR_NODEV | MOUNT_ATTR_NOEXEC;

TEST_F(MountCalls, MakeAStickReadableAndNothingElse) {
  EXPECT_EQ(ask("sda1"), EPERM);
  stop();
  EXPECT_THAT(file_systems_, ElementsAre("vfat", "exfat"));
  EXPECT_THAT(attributes_, ElementsAre(kSafe | MOUNT_ATTR_RDONLY, kSafe | MOUNT_ATTR_RDONLY));
  for (const char* option : {"source=/dev/sda1", "ro", "fmask=0333", "dmask=0222"}) {
    EXPECT_THAT(options_, Contains(option));
  }
  EXPECT_THAT(options_, Not(Contains("rw")));
}

TEST_F(MountCalls, MakeAStickWritableForItsOwnUserAloneAndStillRunNothing) {
  ReportRequest request;
  std::string_view("sda1").copy(request.device.data(), request.device.size() - 1);
  std::string_view("a.json").copy(request.name.data(), request.name.size() - 1);
  constexpr std::array kOne = {STDIN_FILENO};
  EXPECT_EQ(ask(std::string(reinterpret_cast<const char*>(&request), sizeof request), kOne), EPERM);
  stop();
  EXPECT_THAT(attributes_, ElementsAre(kSafe, kSafe));
  const std::string user = "uid=" + std::to_string(::geteuid());
  for (const std::string& option : {std::string("rw"), std::string("fmask=0177"), std::string("dmask=0077"), user}) {
    EXPECT_THAT(options_, Contains(option));
  }
  EXPECT_THAT(options_, Not(Contains("ro")));
}

TEST_F(MountCalls, ComeForNoDeviceThatIsNotOnTheUsbBus) {
  EXPECT_EQ(ask("sdb1"), EACCES);
  stop();
  EXPECT_THAT(file_systems_, ElementsAre());
}

}  // namespace
}  // namespace plumbline
