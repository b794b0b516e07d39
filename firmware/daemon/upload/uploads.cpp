#include "firmware/daemon/upload/uploads.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/daemon/upload/upload_name.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {
namespace {

constexpr std::chrono::minutes kFirstMinute{1};

/// Whether it is a stream socket of this machine: recv(2) with MSG_DONTWAIT never waits for one, whatever its other end does. A pipe
/// would wait, since its other end can make it a waiting one again at any time.
bool is_local_stream(int file) {
  int domain = 0, type = 0;
  socklen_t size = sizeof(int);
  if (::getsockopt(file, SOL_SOCKET, SO_DOMAIN, &domain, &size) != 0 || domain != AF_UNIX) return false;
  size = sizeof(int);
  return ::getsockopt(file, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_STREAM;
}

tl::unexpected<Error> why_not_now(const PrinterRecord& record) {
  if (record.most_upload_bytes == 0) {
    return telling(Told(PrinterCode::kUploadsOff),
                   fail(ErrorCode::kBadSetting,
                        "this printer takes no uploads.\tPut the scan on a stick, or set [printer] upload_mib"));
  }
  if (!at_rest(record.state)) {
    const auto state = to_string(record.state);
    return telling(
        Told(PrinterCode::kUploadNotNow),
        fail(ErrorCode::kBadSetting,
             "the printer takes a scan while it is at rest, and its state is '%.*s'.\tUpload it after the print",
             static_cast<int>(state.size()), state.data()));
  }
  return telling(Told(PrinterCode::kUploadOther),
                 fail(ErrorCode::kBadSetting, "another scan is being uploaded.\tTry again when it is complete"));
}

}  // namespace

Uploads::Uploads(UploadStore store, PrinterRecord& record, const UploadTimes& times)
    : store_(std::move(store)), record_(record), times_(times) {
  record_.most_upload_bytes = store_.most_bytes();
  record_kept();
}

Expected<std::uint32_t> Uploads::begin(const ClientRequest& request, Descriptor from) {
  if (!takes_upload(record_)) return why_not_now(record_);
  if (!is_local_stream(from.get())) {
    return fail(ErrorCode::kBadSetting,
                "no socket for the scan's bytes came with the request.\tHand over one end of socketpair(AF_UNIX, "
                "SOCK_STREAM)");
  }
  PLUMBLINE_TRY(check_upload_name(request.name.view()));
  PLUMBLINE_TRY(store_.begin(request.name.view(), request.bytes));
  const Descriptor before = std::exchange(from_, std::move(from));
  received_ = 0;
  heard_at_ = told_at_ = HostClock::now();
  until_ = heard_at_ + kFirstMinute + std::chrono::seconds(request.bytes / kSlowestBytesPerSecond);
  UploadRecord& upload = record_.upload.emplace();
  upload.number = ++number_;
  upload.bytes = request.bytes;
  assign(upload.name, request.name.view());
  return number_;
}

bool Uploads::receive() {
  if (!is_coming()) return false;
  const auto begin = HostClock::now();
  if (!at_rest(record_.state)) {
    end(Error::format(ErrorCode::kCancelled, "the printer has begun another job.\tUpload the scan after it")
            .tell(PrinterCode::kUploadJobBegan));
    return false;
  }
  for (auto now = begin; now - begin <= times_.turn; now = HostClock::now()) {
    const ssize_t got = ::recv(from_.get(), bytes_.data(), bytes_.size(), MSG_DONTWAIT);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
    if (got < 0 || (got == 0 && !store_.is_whole())) {
      end(Error::format(ErrorCode::kTruncated, "the upload ended after %llu of %llu bytes.\tSend the scan again",
                        static_cast<unsigned long long>(received_),
                        static_cast<unsigned long long>(record_.upload->bytes))
              .tell(how_far(PrinterCode::kUploadBroke)));
      return false;
    }
    if (got == 0) return keep();
    heard_at_ = now;
    received_ += static_cast<std::uint64_t>(got);
    if (const auto written = store_.write(std::span(bytes_).first(static_cast<std::size_t>(got))); !written) {
      end(written.error());
      return false;
    }
  }
  const auto now = HostClock::now();
  tell(now);
  if (now - heard_at_ > times_.silence || now > until_) {
    end(Error::format(ErrorCode::kDeviceTimeout,
                      "the upload was too slow: %llu of %llu bytes arrived.\tCheck the network, then send the scan "
                      "again",
                      static_cast<unsigned long long>(received_),
                      static_cast<unsigned long long>(record_.upload->bytes))
            .tell(how_far(PrinterCode::kUploadSlow)));
  }
  return false;
}

Told Uploads::how_far(PrinterCode code) const {
  constexpr double kMegabyte = 1e6;
  return {code,
          {{PrinterFact::kReceivedMb, static_cast<double>(received_) / kMegabyte},
           {PrinterFact::kTotalMb, static_cast<double>(record_.upload->bytes) / kMegabyte}}};
}

bool Uploads::keep() {
  const auto kept = store_.keep();
  record_kept();
  if (!kept) {
    end(kept.error());
    return false;
  }
  const Descriptor done = std::exchange(from_, Descriptor());
  record_.upload->received = received_;
  record_.upload->stage = UploadRecord::Stage::kKept;
  is_new_ = true;
  return true;
}

Status Uploads::remove(std::string_view name) {
  if (!record_.stored)
    return telling(Told(PrinterCode::kNotInStore, {}, name),
                   fail(ErrorCode::kBadSetting, "there is no scan in the printer's store"));
  if (name != record_.stored->name.view()) {
    return telling(Told(PrinterCode::kNotInStore, {}, name),
                   fail(ErrorCode::kBadSetting, "%s: is not in the printer's store.\tThe scan there is %s",
                        PrintableText(name, 79).c_str(), record_.stored->name.c_str()));
  }
  const auto removed = store_.remove();
  record_kept();
  is_new_ = is_new_ && record_.stored;
  return removed;
}

void Uploads::record_kept() {
  record_.stored.reset();
  if (store_.kept().empty()) return;
  StoredRecord& stored = record_.stored.emplace();
  assign(stored.name, store_.kept());
  stored.bytes = store_.kept_bytes();
}

void Uploads::end(const Error& error) {
  const Descriptor gone = std::exchange(from_, Descriptor());
  store_.drop();
  UploadRecord& upload = *record_.upload;
  upload.received = received_;
  upload.stage = UploadRecord::Stage::kFailed;
  FixedText<400> text;
  text.add("%.*s. %.*s", static_cast<int>(error.finding().size()), error.finding().data(),
           static_cast<int>(error.advice().size()), error.advice().data());
  assign(upload.problem, text.view());
  upload.told = error.told();
}

void Uploads::tell(HostClock::time_point now) {
  if (now - told_at_ < times_.told) return;
  told_at_ = now;
  record_.upload->received = received_;
}

}  // namespace plumbline::firmware
