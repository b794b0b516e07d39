/// How the partitions of a stick are found and asked for.

#include "hal/linux/stick/stick_volume.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/stick/mount_protocol.hpp"
#include "hal/process/passed_descriptor.hpp"

namespace plumbline {
namespace {

using ::testing::HasSubstr;

/// In the place of plumbline-mount: it has folders instead of file systems, by the name of their device.
class FakeMount : public testing::Test {
 protected:
  FakeMount() {
    std::string pattern = (std::filesystem::temp_directory_path() / "plumbline-mount-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    socket().copy(at.sun_path, sizeof at.sun_path - 1);
    listener_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    EXPECT_EQ(::bind(listener_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    EXPECT_EQ(::listen(listener_, 4), 0);
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeMount() override {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
    std::filesystem::remove_all(folder_);
  }

  std::string socket() const { return folder_ + "/socket"; }
  void format(const std::string& device, const char* file = nullptr) {
    std::filesystem::create_directory(std::filesystem::path(folder_) / device);
    if (file != nullptr) std::ofstream(std::filesystem::path(folder_) / device / file) << "x";
  }
  /// The names of the folders that are handed out, and of how many partitions there is nothing.
  std::vector<std::string> mount(const std::vector<std::string>& names, std::size_t unread = 0) {
    std::vector<std::string> nodes, mounted;
    for (const std::string& name : names) nodes.push_back("/dev/" + name);
    auto parts = mount_stick(nodes, socket());
    if (!parts) return {parts.error().message()};
    EXPECT_EQ(parts->unread, unread);
    for (std::size_t i = 0; i < parts->count; ++i) {
      const std::string link = "/proc/self/fd/" + std::to_string(parts->folders[i]);
      mounted.push_back(std::filesystem::read_symlink(link).filename());
    }
    parts->close();
    return mounted;
  }

 private:
  void serve() const {
    for (;;) {
      const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) return;
      ReportRequest request;
      const auto got = receive_message(client, std::as_writable_bytes(std::span(&request, 1)));
      const bool stores = got && got->bytes == sizeof request;
      const std::string device(request.device.data(), stores ? std::strlen(request.device.data()) : got->bytes);
      const int folder = ::open((folder_ + "/" + device).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      int reason = folder >= 0 ? 0 : device == "full" ? ENOSPC : EINVAL;
      if (stores && folder >= 0) reason = copy_report(folder, request.name.data(), got->descriptors()[0], 0, 1);
      got->close_descriptors();
      static_cast<void>(send_message(client, std::as_bytes(std::span(&reason, 1)), {&folder, !stores && folder >= 0}));
      if (folder >= 0) ::close(folder);
      ::close(client);
    }
  }

  std::string folder_;
  int listener_ = -1;
  std::thread thread_;
};

TEST_F(FakeMount, MountsEveryPartitionThatCanBeRead) {
  using ::testing::ElementsAre;
  format("sdb1");  // the EFI partition that a stick of macOS's or with a GPT of Windows's begins with
  format("sdb2", "bust.ply");
  EXPECT_THAT(mount({"sdb1", "sdb2", "sdb"}), ElementsAre("sdb1", "sdb2")) << "and not the medium as a whole";
  EXPECT_THAT(mount({"sdb1", "sdb2", "sdb3", "sdb"}, 1), ElementsAre("sdb1", "sdb2")) << "NTFS behind them";
  EXPECT_THAT(mount({"sda1", "sda", "sdb1", "sdb2", "sdb"}, 1), ElementsAre("sdb1", "sdb2")) << "another slot";
  format("sdc");
  EXPECT_THAT(mount({"sdc"}), ElementsAre("sdc")) << "without a table";
  EXPECT_THAT(mount({"sdc1", "sdc2", "sdc"}), ElementsAre("sdc")) << "with what only looks like one";
  EXPECT_THAT(mount({"sda1", "sda"}), ElementsAre(HasSubstr("/dev/sda1: Invalid argument")));
}

TEST_F(FakeMount, TellsOfPartitionsBeyondTheEighth) {
  std::vector<std::string> names;
  for (int i = 1; i <= 10; ++i) format(names.emplace_back("sdb" + std::to_string(i)));
  names.emplace_back("sdb");
  EXPECT_EQ(mount(names, 2).size(), 8U);
}

TEST_F(FakeMount, StoresAReportOnThePartitionWithItsFolder) {
  format("sdb1");
  format("sdb2", "a");
  const std::string base = socket().substr(0, socket().rfind('/'));
  const int file = ::open((base + "/sdb2/a").c_str(), O_RDONLY | O_CLOEXEC);
  const StickReport report{"a.json", file, 0, 1};
  const auto refused = store_on_stick({"/dev/sdb1", "/dev/sdb2", "/dev/sdb"}, report, socket());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("it has no folder plumbline-reports"));
  const auto full = store_on_stick({"/dev/full", "/dev/sdb1", "/dev/sdb"}, report, socket());
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error().message(), HasSubstr("it is full")) << "whatever another partition lacks";
  std::filesystem::create_directory(base + "/sdb2/plumbline-reports");
  EXPECT_TRUE(store_on_stick({"/dev/sdb1", "/dev/sdb2", "/dev/sdb"}, report, socket()).value());
  EXPECT_FALSE(store_on_stick({"/dev/sdb1", "/dev/sdb2", "/dev/sdb"}, report, socket()).value()) << "it is there";
  EXPECT_TRUE(std::filesystem::exists(base + "/sdb2/plumbline-reports/a.json"));
  ::close(file);
}

}  // namespace
}  // namespace plumbline
