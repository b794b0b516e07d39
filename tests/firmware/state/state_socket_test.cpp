/// The state socket with real clients, well behaved and not.

#include "firmware/state/state_socket.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "firmware/io/text/json_cursor.hpp"
#include "firmware/state/socket_place.hpp"
#include "firmware/state/state_link.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class StateSocketTest : public testing::Test, public CommandTaker {
 protected:
  StateSocketTest() { record_->state = PrintState::kPrinting; }

  /// Deep below a long path: a socket's address has room for 107 characters.
  std::string path() const { return folder_ / std::string(120, 'd') + "/state"; }
  StateLink link(bool commands) const {
    auto made = StateLink::open(path(), commands);
    EXPECT_TRUE(made) << made.error().message();
    return std::move(*made);
  }
  std::optional<EventKind> serve() { return socket_->serve(*record_, *this); }
  std::string line_of(StateLink& link) {
    const auto line = link.next_line(5s);
    return line && *line ? **line : line ? "the end" : line.error().message();
  }
  Expected<std::optional<EventKind>> take(const ClientRequest& request) override {
    taken_.push_back(request.command);
    if (request.command == Command::kCancel) return fail(ErrorCode::kBadSetting, "not now.\tLater");
    return button_of(request.command);
  }

  Expected<std::uint32_t> take_upload(const ClientRequest& upload, Descriptor from) override {
    taken_.push_back(upload.command);
    from_ = std::move(from);
    if (!from_.is_open()) return fail(ErrorCode::kBadSetting, "no socket.\tSend one");
    return 7U;
  }
  Expected<bool> draw_mask(std::uint32_t layer, const MaskWindow&, MaskPicture& picture) override {
    if (turns_until_drawn_ > 0 && turns_until_drawn_-- > 0) return false;
    if (layer > 1) return fail(ErrorCode::kBadSetting, "there is no layer %u: the last one is 1", layer);
    picture.columns = picture.rows = 2;
    picture.bytes()[0] = 255;
    return true;
  }
  Expected<ReportPart> read_report(std::uint64_t from, std::span<std::byte> out) override {
    if (from > 0) return ReportPart{0, 5};
    std::memcpy(out.data(), "hello", 5);
    return ReportPart{5, 5};
  }

  TemporaryFolder folder_;
  bool made_ = std::filesystem::create_directory(folder_ / std::string(120, 'd'));
  std::unique_ptr<PrinterRecord> record_ = std::make_unique<PrinterRecord>();
  std::unique_ptr<StateSocket> socket_ = StateSocket::open(path(), {.turn = 0ns, .patience = 0ns}).value();
  std::vector<Command> taken_;
  int turns_until_drawn_ = 0;
  Descriptor from_;  ///< of the last upload
};

/// A client that hands descriptors over.
class Giver {
 public:
  explicit Giver(const std::string& path) : socket_(SocketPlace::at(path)->connect()) {}
  void send(std::string_view line, std::span<const int> files) const {
    iovec bytes{.iov_base = const_cast<char*>(line.data()), .iov_len = line.size()};
    msghdr message{};
    message.msg_iov = &bytes;
    message.msg_iovlen = 1;
    alignas(cmsghdr) std::array<char, CMSG_SPACE(16 * sizeof(int))> room{};
    message.msg_control = room.data();
    message.msg_controllen = CMSG_SPACE(files.size_bytes());
    cmsghdr* const part = CMSG_FIRSTHDR(&message);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(files.size_bytes());
    std::memcpy(CMSG_DATA(part), files.data(), files.size_bytes());
    EXPECT_EQ(::sendmsg(socket_.get(), &message, MSG_NOSIGNAL), static_cast<ssize_t>(line.size()));
  }
  void send_no_more() const { ::shutdown(socket_.get(), SHUT_WR); }
  std::string receive() const {
    std::array<char, 65536> text{};
    const ssize_t got = ::recv(socket_.get(), text.data(), text.size(), 0);
    return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0))};
  }

 private:
  Descriptor socket_;
};

std::size_t open_files() {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator()));
}

TEST_F(StateSocketTest, SendsTheStateAtOnceAndWhenItHasChanged) {
  StateLink reader = link(false);
  serve();
  const auto first = line_of(reader);
  EXPECT_EQ(json_member(first, "state"), "\"printing\"");
  serve();
  assign(record_->message, "layer 2");
  serve();
  serve();
  const auto second = line_of(reader);
  EXPECT_EQ(json_member(second, "message"), "\"layer 2\"") << "an unchanged state is not sent again";
  EXPECT_EQ(json_member(second, "sequence"), "2");
  StateLink late = link(false);
  serve();
  EXPECT_EQ(line_of(late), second);
}

TEST_F(StateSocketTest, AnswersEachRequestAndTellsOneEventATurn) {
  StateLink user = link(true), other = link(true);
  EXPECT_EQ(serve(), std::nullopt) << "lets them in";
  ASSERT_TRUE(
      user.send("{\"do\":\"pause\",\"id\":1}\n{\"do\":\"cancel\",\"id\":2}\nnonsense\n{\"do\":\"start\",\"id\":4}\n"));
  ASSERT_TRUE(other.send("{\"do\":\"pause\",\"id\":9}\n"));
  EXPECT_EQ(serve(), EventKind::kPausePressed);
  EXPECT_EQ(taken_.size(), 1U);
  EXPECT_EQ(serve(), EventKind::kPausePressed);
  for (int turn = 0; turn < 4; ++turn) EXPECT_EQ(serve(), std::nullopt);
  EXPECT_EQ(json_member(line_of(user), "type"), "\"state\"");
  EXPECT_EQ(line_of(user), R"({"type": "reply", "id": 1, "ok": true})");
  EXPECT_EQ(line_of(user),
            R"({"type": "reply", "id": 2, "ok": false, "error": "not now", "advice": "Later", "told": null})");
  EXPECT_THAT(line_of(user), HasSubstr("not a flat JSON object"));
  EXPECT_THAT(line_of(user), HasSubstr("'printing'. It takes pause, cancel"));
  EXPECT_EQ(json_member(line_of(other), "type"), "\"state\"");
  EXPECT_EQ(line_of(other), R"({"type": "reply", "id": 9, "ok": true})");
}

// Regression: a daemon that hung carried out what a browser had been told was not answered.
TEST_F(StateSocketTest, CarriesNothingOutForWhoeverHasGone) {
  {
    StateLink waits = link(true), early = link(true);
    serve();
    ASSERT_TRUE(waits.send("{\"do\":\"pause\"}\n"));
    ASSERT_TRUE(early.send("{\"do\":\"cancel\"}\n"));
  }
  for (int turn = 0; turn < 3; ++turn) EXPECT_EQ(serve(), std::nullopt);
  // Nor for those who went before they were let in: they take no place either.
  for (std::size_t i = 0; i < 2 * StateSocket::kCommanders; ++i) ASSERT_TRUE(link(true).send("{\"do\":\"pause\"}\n"));
  const Giver user(command_socket(path()));
  for (int turn = 0; turn < 3; ++turn) EXPECT_EQ(serve(), std::nullopt);
  EXPECT_TRUE(taken_.empty());
  EXPECT_THAT(user.receive(), HasSubstr("\"type\": \"state\""));
  // Whoever shuts down for sending still waits for the reply.
  user.send("{\"do\":\"pause\"}\n", std::array{STDOUT_FILENO});
  user.send_no_more();
  EXPECT_EQ(serve(), EventKind::kPausePressed);
  EXPECT_THAT(user.receive(), HasSubstr("\"ok\": true"));
}

TEST_F(StateSocketTest, RefusesACommandThatIsMeantForAnotherQuestionOrJob) {
  record_->state = PrintState::kPaused;
  record_->asks = 0xa;
  record_->job_id = 0xb;
  auto link = this->link(true);
  serve();
  EXPECT_THAT(line_of(link), HasSubstr(R"("asks": "000000000000000a")"));
  const auto reply_to = [&](const char* command, const char* id) {
    FixedText<100> line;
    line.add("{\"do\": \"%s\", \"for\": \"%s\"}\n", command, id);
    EXPECT_TRUE(link.send(std::string(line.view())));
    serve();
    return line_of(link);
  };
  EXPECT_THAT(reply_to("resume", "000000000000000b"), HasSubstr("answer_stale")) << "a job is not a question";
  EXPECT_THAT(reply_to("resume", "000000000000000c"), HasSubstr("nothing was done"));
  EXPECT_THAT(reply_to("cancel", "000000000000000c"), HasSubstr("answer_stale"));
  EXPECT_TRUE(taken_.empty());
  EXPECT_THAT(reply_to("resume", "000000000000000a"), HasSubstr("\"ok\": true"));
  EXPECT_THAT(taken_, ElementsAre(Command::kResume));
  EXPECT_THAT(reply_to("cancel", "000000000000000b"), HasSubstr("not now")) << "the print at hand: the taker is asked";
  // While it prints nobody is asked, so an answer to the question before answers nothing.
  record_->state = PrintState::kPrinting;
  serve();
  EXPECT_THAT(line_of(link), HasSubstr(R"("asks": null)"));
  EXPECT_THAT(reply_to("pause", "000000000000000a"), HasSubstr("answer_stale"));
  EXPECT_EQ(taken_.size(), 2U);
}

TEST_F(StateSocketTest, ShowsNothingOfAnotherJob) {
  record_->job_id = 0xb;
  auto link = this->link(false);
  serve();
  line_of(link);
  const auto reply_to = [&](const char* question) {
    EXPECT_TRUE(link.send(std::string(question) + "\n"));
    serve();
    return line_of(link);
  };
  EXPECT_THAT(reply_to(R"({"do": "mask", "layer": 1, "job": "000000000000000a"})"), HasSubstr("job_stale"));
  EXPECT_THAT(reply_to(R"({"do": "picture", "picture": "layer", "job": "000000000000000a"})"), HasSubstr("job_stale"));
  const auto mask = reply_to(R"({"do": "mask", "layer": 1, "job": "000000000000000b"})");
  EXPECT_THAT(mask, HasSubstr(R"("job": "000000000000000b", "png")"));
  EXPECT_EQ(reply_to(R"({"do": "mask", "layer": 1})"), mask) << "a script that names none";
}

TEST_F(StateSocketTest, IsForEverybodyToReadAndForTheGroupToCommand) {
  struct stat facts {};
  ASSERT_EQ(::stat(path().c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0666U);
  ASSERT_EQ(::stat(command_socket(path()).c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0660U);
  StateLink reader = link(false);
  ASSERT_TRUE(reader.send("{\"do\":\"pause\"}\n"));
  for (int turn = 0; turn < 2; ++turn) EXPECT_EQ(serve(), std::nullopt);
  EXPECT_EQ(json_member(line_of(reader), "type"), "\"state\"");
  EXPECT_THAT(line_of(reader), HasSubstr("this socket is for reading"));
  EXPECT_TRUE(taken_.empty());
}

TEST_F(StateSocketTest, ShowsMasksAndAReportToWhoeverMayReadAndCodesToNobody) {
  StateLink reader = link(false), user = link(true);
  record_->has_report = true;
  assign(record_->code, "482913");
  serve();
  ASSERT_TRUE(
      reader.send("{\"do\":\"mask\",\"layer\":1,\"id\":1}\n{\"do\":\"mask\",\"layer\":2}\n"
                  "{\"do\":\"report\",\"from\":0}\n{\"do\":\"code\",\"code\":\"1\"}\n"));
  for (int turn = 0; turn < 4; ++turn) serve();
  const std::string state = line_of(reader);
  EXPECT_EQ(state.find("482913"), std::string::npos);
  EXPECT_EQ(json_member(state, "report"), "false") << "the storage may take its time only when nothing is printed";
  EXPECT_THAT(line_of(reader), HasSubstr(R"({"type": "reply", "id": 1, "ok": true, "layer": 1, "png": "iVBORw0KGgo)"));
  EXPECT_THAT(line_of(reader), HasSubstr("there is no layer 2"));
  EXPECT_THAT(line_of(reader), HasSubstr("there is no report now"));
  EXPECT_THAT(line_of(reader), HasSubstr("this socket is for reading"));
  record_->state = PrintState::kPlateInUse;
  ASSERT_TRUE(reader.send("{\"do\":\"report\",\"from\":0,\"id\":4}\n{\"do\":\"report\",\"from\":5}\n"));
  for (int turn = 0; turn < 2; ++turn) serve();
  EXPECT_EQ(json_member(line_of(reader), "report"), "true");
  EXPECT_EQ(line_of(reader), R"({"type": "reply", "id": 4, "ok": true, "from": 0, "size": 5, "data": "aGVsbG8="})");
  EXPECT_THAT(line_of(reader), HasSubstr(R"("size": 5, "data": "")"));
  EXPECT_TRUE(taken_.empty());
  ASSERT_TRUE(user.send("{\"do\":\"code\",\"code\":\"123\"}\n"));
  serve();
  EXPECT_EQ(taken_, std::vector<Command>{Command::kCode});
}

TEST_F(StateSocketTest, TakesTheSocketOfAnUploadAndNoOtherDescriptor) {
  const Giver user(command_socket(path())), reader(path());
  serve();
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  const Descriptor ours(ends[0]), theirs(ends[1]);
  const std::size_t files = open_files();
  constexpr std::string_view kUpload = "{\"do\":\"upload\",\"name\":\"a.ply\",\"bytes\":5,\"id\":1}\n";
  user.send(kUpload, std::span(&ends[1], 1));
  serve();
  ASSERT_TRUE(from_.is_open());
  EXPECT_THAT(user.receive(), HasSubstr(R"({"type": "reply", "id": 1, "ok": true, "upload": 7})"));
  ASSERT_EQ(::send(ours.get(), "x", 1, 0), 1);
  char got = 0;
  EXPECT_EQ(::recv(from_.get(), &got, 1, MSG_DONTWAIT), 1);
  EXPECT_NE(static_cast<unsigned>(::fcntl(from_.get(), F_GETFD)) & static_cast<unsigned>(FD_CLOEXEC), 0U);
  { const Descriptor gone = std::exchange(from_, Descriptor()); }
  // Many of them, with another request, or from somebody who may only read: all are closed.
  const std::array<int, 16> many{ends[0], ends[0], ends[0], ends[0], ends[0], ends[0], ends[0], ends[0],
                                 ends[0], ends[0], ends[0], ends[0], ends[0], ends[0], ends[0], ends[0]};
  user.send("{\"do\":\"pause\"}\n", many);
  reader.send(kUpload, many);
  serve();
  EXPECT_LE(open_files(), files + 1) << "one at most is kept, for an upload that may follow";
  EXPECT_THAT(reader.receive(), HasSubstr("this socket is for reading"));
  user.send(kUpload, many);
  serve();
  { const Descriptor gone = std::exchange(from_, Descriptor()); }
  EXPECT_EQ(open_files(), files);
  StateLink without = link(true);
  serve();
  ASSERT_TRUE(without.send(std::string(kUpload)));
  serve();
  EXPECT_EQ(json_member(line_of(without), "type"), "\"state\"");
  EXPECT_THAT(line_of(without), HasSubstr("no socket"));
}

TEST_F(StateSocketTest, TurnsAwayWhoeverIsOneTooManyButNotThoseWhoCommand) {
  std::vector<StateLink> readers;
  for (std::size_t i = 0; i < 3 * StateSocket::kReaders; ++i) {
    readers.push_back(link(false));
    serve();
  }
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const bool in = i < StateSocket::kReaders;
    EXPECT_THAT(line_of(readers[i]), HasSubstr(in ? "\"type\": \"state\"" : "8 clients are connected"));
    if (!in) {
      EXPECT_EQ(line_of(readers[i]), "the end");
    }
  }
  StateLink user = link(true);
  serve();
  EXPECT_EQ(json_member(line_of(user), "type"), "\"state\"");
  readers.clear();
  serve();
  StateLink next = link(false);
  serve();
  EXPECT_EQ(json_member(line_of(next), "type"), "\"state\"") << "their places are free again";
}

TEST_F(StateSocketTest, DropsAClientThatReadsNothingAndKeepsTheOthers) {
  StateLink sleeper = link(false), reader = link(false);
  serve();
  line_of(reader);
  // Until the kernel takes no more of the sleeper's.
  for (int i = 0; i < 2000; ++i) {
    assign(record_->message, std::string(300, 'x') + std::to_string(i));
    serve();
    ASSERT_THAT(line_of(reader), HasSubstr(std::to_string(i)));
  }
  std::size_t lines = 0;
  while (line_of(sleeper) != "the end") ++lines;
  EXPECT_GT(lines, 10U);
  EXPECT_LT(lines, 1500U) << "it was dropped, with what the kernel had taken";
}

TEST_F(StateSocketTest, AnswersAMaskWhenItIsReadyAndKeepsTheOrder) {
  StateLink reader = link(false), user = link(true);
  serve();
  line_of(reader);
  line_of(user);
  turns_until_drawn_ = 3;
  ASSERT_TRUE(reader.send("{\"do\":\"mask\",\"layer\":1,\"id\":1}\n{\"do\":\"mask\",\"layer\":7,\"id\":2}\n"));
  for (int turn = 0; turn < 3; ++turn) {
    ASSERT_TRUE(user.send("{\"do\":\"pause\",\"id\":9}\n"));
    EXPECT_EQ(serve(), EventKind::kPausePressed) << "others are served meanwhile";
    EXPECT_THAT(line_of(user), HasSubstr("\"id\": 9, \"ok\": true"));
  }
  serve();
  serve();
  EXPECT_THAT(line_of(reader), HasSubstr("\"id\": 1, \"ok\": true, \"layer\": 1"));
  EXPECT_THAT(line_of(reader), HasSubstr("\"id\": 2, \"ok\": false, \"error\": \"there is no layer 7"));
}

TEST_F(StateSocketTest, DropsAClientThatAsksAndDoesNotReadTheReplies) {
  StateLink flood = link(true), user = link(true);
  for (int i = 0; i < 4000 && flood.send("x\n"); ++i) serve();
  serve();
  EXPECT_FALSE(flood.send("x\n")) << "it is gone";
  ASSERT_TRUE(user.send("{\"do\":\"pause\"}\n"));
  EXPECT_EQ(serve(), EventKind::kPausePressed);
}

TEST_F(StateSocketTest, AnswersALineWithoutAnEndAndDropsIt) {
  StateLink endless = link(true), cut = link(true), half = link(true);
  ASSERT_TRUE(endless.send(std::string(100'000, '{')));
  ASSERT_TRUE(cut.send("{\"do\":\"pau"));
  { const StateLink gone = std::move(cut); }
  ASSERT_TRUE(half.send("{\"do\":\"st\xc3\n"));
  for (int turn = 0; turn < 4; ++turn) EXPECT_EQ(serve(), std::nullopt);
  EXPECT_EQ(json_member(line_of(endless), "type"), "\"state\"");
  EXPECT_THAT(line_of(endless), HasSubstr("more than 1023 bytes"));
  EXPECT_EQ(line_of(endless), "the end");
  EXPECT_EQ(json_member(line_of(half), "type"), "\"state\"");
  EXPECT_THAT(line_of(half), HasSubstr("not a flat JSON object"));
  EXPECT_TRUE(taken_.empty());
}

TEST_F(StateSocketTest, IsOneDaemonsAndIsOpenedAgainAfterItWasKilled) {
  const auto second = StateSocket::open(path());
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message(), HasSubstr("another plumblined"));
  socket_.reset();  // the files stay, as after a kill
  EXPECT_THAT(StateLink::open(path(), false).error().message(), HasSubstr("no plumblined serves"));
  const auto again = StateSocket::open(path());
  EXPECT_TRUE(again) << again.error().message();
  EXPECT_THAT(StateSocket::open(folder_ / "none/state").error().message(), HasSubstr("state_socket"));
}

}  // namespace
}  // namespace plumbline::firmware
