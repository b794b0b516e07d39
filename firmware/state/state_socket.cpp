#include "firmware/state/state_socket.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "firmware/io/random_id.hpp"
#include "firmware/io/text/base64.hpp"
#include "firmware/messages/printer_code.hpp"
#include "firmware/state/command_rules.hpp"
#include "firmware/state/socket_place.hpp"

namespace plumbline::firmware::inline state {
namespace {

/// Connections that wait to be let in, and those let in each turn.
constexpr int kBacklog = 16;
/// A whole state line fits, so that a client that reads now and then is never owed a part of one.
constexpr int kSendBuffer = 2 * static_cast<int>(kLongestLine);

/// Bytes of a report in one reply.
constexpr std::size_t kReportPart = std::size_t{24} * 1024;

constexpr mode_t kEveryone = 0666;
constexpr mode_t kOwnerAndGroup = 0660;

Expected<Descriptor> listen_at(const std::string& path, mode_t mode) {
  const auto place = SocketPlace::at(path);
  PLUMBLINE_TRY(place);
  if (place->connect().is_open() || errno == EAGAIN) {
    return fail(ErrorCode::kCannotOpen,
                "%s: another plumblined serves its state there.\tEnd it, or name another socket", path.c_str());
  }
  // One that a killed daemon left.
  static_cast<void>(::unlinkat(place->folder(), place->name().c_str(), 0));
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const sockaddr_un address = place->address();
  if (socket.is_open() && ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::fchmodat(place->folder(), place->name().c_str(), mode, 0) == 0 && ::listen(socket.get(), kBacklog) == 0) {
    return socket;
  }
  const int reason = errno;
  return fail(ErrorCode::kCannotOpen, "%s: %s", path.c_str(), std::strerror(reason));
}

}  // namespace

Expected<std::unique_ptr<StateSocket>> StateSocket::open(const std::string& path, const StateSocketTimes& times) {
  auto pictures = PictureLine::create();
  PLUMBLINE_TRY(pictures);
  std::unique_ptr<StateSocket> socket(new StateSocket(times, std::move(*pictures)));
  auto readers = listen_at(path, kEveryone);
  PLUMBLINE_TRY(readers);
  auto commanders = listen_at(command_socket(path), kOwnerAndGroup);
  PLUMBLINE_TRY(commanders);
  const std::span<StateClient> all(socket->clients_);
  socket->doors_ = {Door{std::move(*readers), all.first(kReaders), false},
                    Door{std::move(*commanders), all.subspan(kReaders), true}};
  return socket;
}

std::optional<EventKind> StateSocket::serve(const PrinterRecord& record, CommandTaker& taker) {
  now_ = HostClock::now();
  if (now_ - served_at_ < times_.turn) return std::nullopt;
  const auto event = serve_all(record, taker);
  served_at_ = HostClock::now();
  return event;
}

std::optional<EventKind> StateSocket::serve_all(const PrinterRecord& record, CommandTaker& taker) {
  write_state(record);
  std::optional<EventKind> event;
  for (Door& door : doors_) {
    for (StateClient& client : door.clients) {
      if (client.is_open()) serve_client(client, door, record, taker, event);
    }
    // Afterwards: whoever has left makes room.
    let_in(door);
  }
  return event;
}

/// Writes the state's line, under a new number if it differs from the last one.
void StateSocket::write_state(const PrinterRecord& record) {
  next_.clear();
  if (!write_state_line(next_, record, sequence_) || next_.view() == line_.view()) return;
  line_.clear();
  static_cast<void>(write_state_line(line_, record, ++sequence_));
}

void StateSocket::let_in(Door& door) {
  for (int i = 0; i < kBacklog; ++i) {
    Descriptor socket(::accept4(door.listener.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket.is_open()) return;
    if (StateClient::has_gone(socket)) continue;  // it takes no place
    static_cast<void>(::setsockopt(socket.get(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer));
    auto* const client = std::find_if_not(door.clients.data(), door.clients.data() + door.clients.size(),
                                          [](const StateClient& one) { return one.is_open(); });
    if (client != door.clients.data() + door.clients.size()) {
      client->open(std::move(socket), door.may_command);
      client->send_state(line_.view(), sequence_);
      continue;
    }
    const Error full = Error::format(ErrorCode::kBusy, "%zu clients are connected.\tEnd one of them, then try again",
                                     door.clients.size());
    reply_.clear();
    static_cast<void>(write_reply_line(reply_, std::nullopt, &full));
    static_cast<void>(::send(socket.get(), reply_.view().data(), reply_.view().size(), MSG_DONTWAIT | MSG_NOSIGNAL));
  }
}

void StateSocket::serve_client(StateClient& client, const Door& door, const PrinterRecord& record, CommandTaker& taker,
                               std::optional<EventKind>& event) {
  if (client.flush(now_, times_.patience)) client.send_state(line_.view(), sequence_);
  // A command may change everything, so others wait for the next turn.
  if (!client.is_open() || event) return;
  const auto line = client.line();
  if (!client.is_open()) return;
  if (!line) {
    if (client.is_flooding()) {
      const Error error = Error::format(ErrorCode::kMalformed, "a line has more than %zu bytes", kLongestRequest);
      answer(client, std::nullopt, &error);
      client.drop();
    } else if (client.is_done()) {
      client.drop();
    }
    return;
  }
  // Nobody has heard that it was taken, and whoever has waited in vain may have done otherwise meanwhile.
  if (client.has_gone()) return client.drop();
  std::optional<std::uint64_t> id;
  std::optional<Error> error;
  const auto request = parse_request(*line, id);
  std::optional<Expected<bool>> answered;
  if (request && is_question(request->command)) {
    reply_.clear();
    answered = write_answer(id, *request, record, taker);
    // The line stays, and so do those behind it: replies come in order.
    if (*answered && !**answered) return;
  }
  client.take_line();
  if (!request) {
    error = request.error();
  } else if (answered) {
    if (*answered) return client.send(reply_.view());
    error = answered->error();
  } else if (!door.may_command) {
    error = Error::format(ErrorCode::kBadSetting,
                          "this socket is for reading.\tConnect to the one beside it whose name ends in .command");
  } else if (!is_meant(record, request->command, request->about)) {
    error = Error::format(
                ErrorCode::kBadSetting,
                "that is for another question or job than the one at hand, so nothing was done.\tLook at what the "
                "printer asks now")
                .tell(PrinterCode::kAnswerStale);
  } else if (request->command == Command::kUpload) {
    const auto number = taker.take_upload(*request, client.handed_over());
    if (number) {
      reply_.clear();
      static_cast<void>(write_reply_line(reply_, id, nullptr, *number));
      return client.send(reply_.view());
    }
    error = number.error();
  } else if (!takes(record, request->command)) {
    error =
        Error::format(ErrorCode::kBadSetting, "%s", what_it_takes(record).c_str()).tell(PrinterCode::kCommandNotNow);
  } else if (const auto taken = taker.take(*request)) {
    event = *taken;
  } else {
    error = taken.error();
  }
  answer(client, id, error ? &*error : nullptr);
}

void StateSocket::answer(StateClient& client, std::optional<std::uint64_t> id, const Error* error) {
  reply_.clear();
  static_cast<void>(write_reply_line(reply_, id, error));
  client.send(reply_.view());
}

/// @returns false: there is no answer yet
Expected<bool> StateSocket::write_answer(std::optional<std::uint64_t> id, const ClientRequest& question,
                                         const PrinterRecord& record, CommandTaker& taker) {
  if (question.job != 0 && question.job != record.job_id) {
    return telling(Told(PrinterCode::kJobStale),
                   fail(ErrorCode::kBadSetting,
                        "that is of another job than the one at hand.\tThe state's \"job\" has "
                        "the id of that"));
  }
  if (question.print > 0) {
    PLUMBLINE_TRY(write_kept(id, question, record));
  } else if (question.command == Command::kPicture && question.picture == PictureName::kPart) {
    PLUMBLINE_TRY(write_model(id, question.from, record));
  } else if (question.command == Command::kPicture) {
    const std::uint32_t which = question.picture == PictureName::kScan ? question.scan - 1 : question.which;
    PLUMBLINE_TRY(pictures_.write(reply_, id, question.picture, which, record));
  } else if (question.command == Command::kMask) {
    const auto drawn = taker.draw_mask(question.layer, question.window, pictures_.mask());
    PLUMBLINE_TRY(drawn);
    if (!*drawn) return false;
    PLUMBLINE_TRY(pictures_.write_mask(reply_, id, question.layer, record.job_id));
  } else if (!record.has_report || !at_rest(record.state)) {
    return fail(ErrorCode::kBadSetting, "there is no report now.\tAsk again when the print is over");
  } else {
    PLUMBLINE_TRY(write_report(id, question.from, taker));
  }
  return true;
}

Status StateSocket::write_report(std::optional<std::uint64_t> id, std::uint64_t from, CommandTaker& taker) {
  std::array<std::byte, kReportPart> bytes;
  const auto part = taker.read_report(from, bytes);
  PLUMBLINE_TRY(part);
  return write_part(id, from, part->size, std::span(bytes).first(part->bytes));
}

/// A part of the model of what has been sliced.
Status StateSocket::write_model(std::optional<std::uint64_t> id, std::uint64_t from, const PrinterRecord& record) {
  const auto drawn = drawn_picture(record, PictureName::kPart, 0);
  if (!drawn || from >= drawn->bytes.size()) {
    return fail(ErrorCode::kBadSetting,
                "there is no such part of a picture 'part' now.\tThe state's \"pictures\" says which there are");
  }
  const auto rest = std::as_bytes(drawn->bytes).subspan(static_cast<std::size_t>(from));
  FixedText<100> of;
  of.add("\"picture\": \"part\", \"number\": %u, \"job\": \"%s\", ", drawn->number, id_text(record.job_id).c_str());
  return write_part(id, from, drawn->bytes.size(), rest.first(std::min(rest.size(), kReportPart)), of.view());
}

/// Of a print that is kept.
Status StateSocket::write_kept(std::optional<std::uint64_t> id, const ClientRequest& question,
                               const PrinterRecord& record) {
  if (record.prints == nullptr || !at_rest(record.state)) {
    return fail(ErrorCode::kBadSetting, "no earlier print can be read now.\tAsk again when the print is over");
  }
  if (question.command == Command::kPicture) {
    if (question.picture != PictureName::kPreview) {
      return fail(ErrorCode::kBadSetting, "only the preview of a print is kept.\tAsk for \"picture\": \"preview\"");
    }
    return pictures_.write_kept(reply_, id, *record.prints, question.print);
  }
  std::array<std::byte, kReportPart> bytes;
  const auto part = record.prints->read(question.print, KeptPrints::Part::kReport, question.from, bytes);
  PLUMBLINE_TRY(part);
  return write_part(id, question.from, part->size, std::span(bytes).first(part->bytes));
}

Status StateSocket::write_part(std::optional<std::uint64_t> id, std::uint64_t from, std::uint64_t size,
                               std::span<const std::byte> bytes, std::string_view of) {
  std::array<char, (kReportPart + 2) / 3 * 4> base64;
  const auto characters = write_base64(bytes, base64);
  FixedText<180> members;
  members.add("%.*s\"from\": %llu, \"size\": %llu", static_cast<int>(of.size()), of.data(),
              static_cast<unsigned long long>(from), static_cast<unsigned long long>(size));
  return write_data_line(reply_, id, members.view(), "data", {base64.data(), characters.value_or(0)});
}

}  // namespace plumbline::firmware::inline state
