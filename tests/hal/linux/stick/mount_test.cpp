/// The real plumbline-mount. That it mounts real sticks is tested on the emulated board (tests/hil/rig).

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/stick/mount_protocol.hpp"
#include "hal/linux/stick/stick_volume.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline {
namespace {

using ::testing::HasSubstr;

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

}  // namespace
}  // namespace plumbline
