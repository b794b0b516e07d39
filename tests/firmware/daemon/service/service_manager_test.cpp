/// The messages to the service manager, received from a real socket.

#include "firmware/daemon/service/service_manager.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "firmware/daemon/service/service_events.hpp"
#include "firmware/daemon/service/service_status.hpp"
#include "firmware/state/command_rules.hpp"
#include "firmware/state/state_link.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// systemd's end of the socket.
class ManagerSocket {
 public:
  explicit ManagerSocket(std::string address) : address_(std::move(address)) {
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    std::copy(address_.begin(), address_.end(), at.sun_path);
    if (address_[0] == '@') at.sun_path[0] = '\0';
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&at), length), 0) << address_;
  }
  ManagerSocket(const ManagerSocket&) = delete;
  ManagerSocket& operator=(const ManagerSocket&) = delete;
  ~ManagerSocket() { ::close(socket_); }

  const std::string& address() const { return address_; }
  /// The datagrams since the last call.
  std::vector<std::string> received() {
    std::vector<std::string> messages;
    std::array<char, 4096> text{};
    for (;;) {
      const ssize_t got = ::recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
      if (got < 0) return messages;
      messages.emplace_back(text.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  std::string address_;
  int socket_ = -1;
};

class Service : public testing::Test {
 protected:
  ServiceManager manager(std::chrono::microseconds watchdog = 0us) const {
    auto made = ServiceManager::at(socket_.address(), watchdog);
    EXPECT_TRUE(made) << made.error().message();
    return std::move(*made);
  }

  TemporaryFolder folder_;
  ManagerSocket socket_{folder_ / "notify"};
};

TEST_F(Service, GetsEachMessageInItsOwnDatagram) {
  auto manager = this->manager();
  EXPECT_TRUE(manager.ready());
  manager.status("waiting for a stick");
  manager.stopping();
  EXPECT_THAT(socket_.received(), ElementsAre("READY=1", "STATUS=waiting for a stick", "STOPPING=1"));
}

TEST_F(Service, GetsMessagesAtAnAbstractName) {
  ManagerSocket other("@plumbline-test-" + std::to_string(::getpid()));
  auto manager = ServiceManager::at(other.address(), 0us);
  ASSERT_TRUE(manager) << manager.error().message();
  EXPECT_TRUE(manager->ready());
  EXPECT_THAT(other.received(), ElementsAre("READY=1"));
}

TEST_F(Service, GetsNoStatusTwiceAndNoneThatHoldsAnotherMessage) {
  auto manager = this->manager();
  manager.status("a scan\nREADY=1");
  manager.status("a scan");
  manager.status("a scan");
  manager.status(std::string(1000, 'x'));
  const auto received = socket_.received();
  ASSERT_THAT(received, SizeIs(3));
  EXPECT_EQ(received[0], "STATUS=a scan\\x0aREADY=1");
  EXPECT_EQ(received[1], "STATUS=a scan");
  EXPECT_EQ(received[2], "STATUS=" + std::string(237, 'x') + "...");
}

TEST_F(Service, GetsASignOfLifeAfterHalfTheWatchdogTimeAndNotBefore) {
  auto patient = manager(60s);
  for (int turn = 0; turn < 1000; ++turn) patient.alive();
  EXPECT_THAT(socket_.received(), ElementsAre("WATCHDOG=1")) << "a thousand turns take less than 30 s";
  constexpr auto kShort = 1us;
  auto hasty = manager(kShort);
  for (int turn = 0; turn < 5; ++turn) {
    // A turn can be shorter than half the watchdog's time, so wait for all of it.
    const auto said = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - said < kShort) {
    }
    hasty.alive();
  }
  EXPECT_THAT(socket_.received(), AllOf(SizeIs(5), Each("WATCHDOG=1")));
  auto unwatched = manager();
  unwatched.alive();
  EXPECT_THAT(socket_.received(), IsEmpty());
}

TEST_F(Service, DoesNotHoldTheDaemonUpByNotReading) {
  auto manager = this->manager(1us);
  // Far more messages than the kernel buffers.
  for (int turn = 0; turn < 10'000; ++turn) {
    manager.alive();
    manager.status(std::to_string(turn));
  }
  EXPECT_THAT(socket_.received(), testing::Not(IsEmpty()));
  manager.status("9999");
  EXPECT_THAT(socket_.received(), ElementsAre("STATUS=9999")) << "a status that was lost is sent when it is set again";
}

TEST_F(Service, ThatHasGoneIsAnErrorOnlyForReady) {
  auto gone = std::make_unique<ManagerSocket>(folder_ / "gone");
  auto manager = ServiceManager::at(gone->address(), 1us);
  ASSERT_TRUE(manager);
  gone.reset();
  manager->status("anybody there");
  manager->alive();
  const auto told = manager->ready();
  ASSERT_FALSE(told);
  EXPECT_EQ(told.error().code(), ErrorCode::kCannotWrite);
}

TEST_F(Service, MayBeMissing) {
  ServiceManager nobody;
  EXPECT_TRUE(nobody.ready());
  nobody.status("ready");
  nobody.alive();
  nobody.stopping();
  EXPECT_FALSE(nobody.watches());
}

/// Restores the environment afterwards.
class ServiceEnvironment : public Service {
 protected:
  ~ServiceEnvironment() override { clear(); }
  static void clear() {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) ::unsetenv(name);
  }
  static Expected<ServiceManager> with(const std::vector<std::pair<const char*, std::string>>& variables) {
    clear();
    for (const auto& [name, value] : variables) ::setenv(name, value.c_str(), 1);
    return ServiceManager::of_environment();
  }
  std::string socket() const { return socket_.address(); }
};

TEST_F(ServiceEnvironment, NamesTheSocketAndTheWatchdog) {
  const auto nobody = with({});
  ASSERT_TRUE(nobody);
  EXPECT_FALSE(nobody->watches());
  EXPECT_EQ(with({{"NOTIFY_SOCKET", socket()}})->watchdog(), 0us);
  const std::string self = std::to_string(::getpid());
  EXPECT_EQ(with({{"NOTIFY_SOCKET", socket()}, {"WATCHDOG_USEC", "120000000"}})->watchdog(), 120s);
  EXPECT_EQ(with({{"NOTIFY_SOCKET", socket()}, {"WATCHDOG_USEC", "5000000"}, {"WATCHDOG_PID", self}})->watchdog(), 5s);
  EXPECT_FALSE(with({{"NOTIFY_SOCKET", socket()}, {"WATCHDOG_USEC", "5000000"}, {"WATCHDOG_PID", "1"}})->watches())
      << "the watchdog is another process's";
}

TEST_F(ServiceEnvironment, IsCheckedBeforeAnythingElse) {
  const auto refused = [](const Expected<ServiceManager>& made, ErrorCode code, const char* words) {
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code(), code);
    EXPECT_THAT(made.error().message(), HasSubstr(words));
  };
  refused(with({{"NOTIFY_SOCKET", "notify"}}), ErrorCode::kBadSetting, "found 'notify'");
  refused(with({{"NOTIFY_SOCKET", "@"}}), ErrorCode::kBadSetting, "found '@'");
  refused(with({{"NOTIFY_SOCKET", "/" + std::string(107, 'x')}}), ErrorCode::kBadSetting, "a path");
  refused(with({{"NOTIFY_SOCKET", folder_ / "nothing"}}), ErrorCode::kCannotOpen, "No such file");
  for (const char* wrong : {"", "0", "-5", "5s", "99999999999999999999"}) {
    refused(with({{"NOTIFY_SOCKET", socket()}, {"WATCHDOG_USEC", wrong}}), ErrorCode::kBadSetting, "WATCHDOG_USEC");
  }
}

/// A machine with one event. Its time passes only during waits.
class Still final : public Clock, public Events {
 public:
  std::vector<TimePoint> deadlines;
  std::optional<Event> event;  ///< comes at its time, once

 private:
  TimePoint do_now() const override { return now_; }
  Status do_sleep_until(TimePoint deadline) override {
    now_ = deadline;
    return {};
  }
  Expected<std::optional<Event>> do_next_event(TimePoint deadline) override {
    deadlines.push_back(deadline);
    if (event && event->at <= deadline) {
      now_ = std::max(now_, event->at);
      return std::exchange(event, std::nullopt);
    }
    now_ = std::max(now_, deadline);
    return std::nullopt;
  }

  TimePoint now_;
};

TEST_F(Service, GetsSignsOfLifeDuringALongWait) {
  Still machine;
  auto manager = this->manager(1us);
  ServiceEvents events(machine, machine, manager);
  EXPECT_EQ(*events.next_event(TimePoint(1us)), std::nullopt);
  EXPECT_EQ(machine.now(), TimePoint(1us));
  EXPECT_THAT(machine.deadlines, ElementsAre(TimePoint(250ns), TimePoint(500ns), TimePoint(750ns), TimePoint(1us)));
  EXPECT_THAT(socket_.received(), testing::Contains("WATCHDOG=1"));

  machine.deadlines.clear();
  auto patient = this->manager(1h);
  ServiceEvents slow(machine, machine, patient);
  EXPECT_EQ(*slow.next_event(TimePoint(3s)), std::nullopt);
  EXPECT_THAT(machine.deadlines, SizeIs(15)) << "five turns a second, however long the watchdog waits";
}

TEST_F(Service, GetsASignOfLifeFromPolling) {
  Still machine;
  auto manager = this->manager(1h);
  ServiceEvents events(machine, machine, manager);
  for (int turn = 0; turn < 100; ++turn) EXPECT_EQ(*events.next_event(machine.now()), std::nullopt);
  EXPECT_EQ(machine.now(), TimePoint()) << "without waiting";
  EXPECT_THAT(socket_.received(), ElementsAre("WATCHDOG=1"));
}

TEST_F(Service, DoesNotChangeEventsAndGetsTheEnd) {
  Still machine;
  auto manager = this->manager(20s);
  ServiceEvents events(machine, machine, manager);
  machine.event = Event{TimePoint(2500ms), EventKind::kPausePressed};
  auto got = events.next_event(TimePoint(1h));
  ASSERT_TRUE(got && *got);
  EXPECT_EQ((*got)->kind, EventKind::kPausePressed);
  EXPECT_EQ(machine.now(), TimePoint(2500ms));
  EXPECT_THAT(socket_.received(), ElementsAre("WATCHDOG=1"));
  machine.event = Event{TimePoint(3s), EventKind::kShutdownRequested};
  got = events.next_event(TimePoint(1h));
  ASSERT_TRUE(got && *got);
  EXPECT_THAT(socket_.received(), ElementsAre("STOPPING=1"));
}

/// Takes every command.
class Obedient final : public CommandTaker {
 public:
  Expected<std::optional<EventKind>> take(const ClientRequest& request) override { return button_of(request.command); }
};

TEST_F(Service, DeliversACommandWithinAFifthOfASecond) {
  Still machine;
  auto manager = this->manager();
  ServiceEvents events(machine, machine, manager);
  const auto socket = StateSocket::open(folder_ / "state");
  ASSERT_TRUE(socket) << socket.error().message();
  PrinterRecord record;
  record.state = PrintState::kPrinting;
  Obedient taker;
  events.serve(**socket, record, taker);
  EXPECT_EQ(*events.next_event(TimePoint(1s)), std::nullopt);
  EXPECT_THAT(machine.deadlines, SizeIs(5)) << "also without a watchdog";
  auto link = StateLink::open(folder_ / "state", true);
  ASSERT_TRUE(link) << link.error().message();
  ASSERT_TRUE(link->send("{\"do\": \"pause\"}\n"));
  const auto got = events.next_event(TimePoint(100h));
  ASSERT_TRUE(got && *got);
  EXPECT_EQ((*got)->kind, EventKind::kPausePressed);
}

TEST(ServiceStatus, SaysHowThePrintEnded) {
  PrintReport report;
  report.state = PrintState::kFinished;
  EXPECT_EQ(service_status(report).view(), "finished");
  report.state = PrintState::kFault;
  report.fault = FaultCode::kFlipTimeout;
  EXPECT_EQ(service_status(report).view(), "PL-201, panel did not take a mask. Check the panel's cable, then resume.");
}

}  // namespace
}  // namespace plumbline::firmware
