#include "slicer/reader/stream/xml_parser.hpp"

#include <expat.h>

#include <cstdarg>
#include <cstdio>

namespace plumbline::inline slicer {
namespace {

/// expat's functions for memory take no context.
thread_local FixedHeap* heap_of_parser = nullptr;

const XML_Memory_Handling_Suite kMemory = {
    [](std::size_t bytes) { return heap_of_parser->allocate(bytes); },
    [](void* old, std::size_t bytes) { return heap_of_parser->reallocate(old, bytes); },
    [](void* part) { heap_of_parser->release(part); },
};

XML_Parser parser_in(FixedHeap& heap) {
  heap_of_parser = &heap;
  return XML_ParserCreate_MM(nullptr, &kMemory, nullptr);
}

}  // namespace

std::string_view XmlAttributes::any(std::string_view name) const {
  for (const char** at = list_; *at != nullptr; at += 2) {
    const std::string_view full = at[0];
    if (full.ends_with(name) && (full.size() == name.size() || full[full.size() - name.size() - 1] == ':')) {
      return at[1];
    }
  }
  return {};
}

XmlParser::XmlParser(FixedHeap& heap, XmlHandler& handler) : heap_(heap), handler_(handler), parser_(parser_in(heap)) {
  handler.parser_ = this;
  if (parser_ == nullptr) return;
  XML_SetHashSalt(parser_, 1);  // expat would ask the kernel for a random one
  XML_SetUserData(parser_, this);
  XML_SetElementHandler(
      parser_,
      [](void* user, const XML_Char* name, const XML_Char** attributes) {
        static_cast<XmlParser*>(user)->handler_.begin(name, XmlAttributes(attributes));
      },
      [](void* user, const XML_Char* name) { static_cast<XmlParser*>(user)->handler_.end(name); });
  XML_SetCharacterDataHandler(parser_, [](void* user, const XML_Char* text, int length) {
    static_cast<XmlParser*>(user)->handler_.text({text, static_cast<std::size_t>(length)});
  });
  XML_SetStartDoctypeDeclHandler(
      parser_, [](void* user, const XML_Char* /*name*/, const XML_Char* /*system*/, const XML_Char* /*open*/,
                  int /*has_internal*/) { static_cast<XmlParser*>(user)->complain("a document type"); });
}

XmlParser::~XmlParser() {
  if (parser_ != nullptr) XML_ParserFree(parser_);
  heap_of_parser = nullptr;
}

void XmlParser::complain(const char* pattern, ...) {
  if (complaint_[0] != 0) return;
  va_list args;
  va_start(args, pattern);
  std::vsnprintf(complaint_.data(), complaint_.size(), pattern, args);
  va_end(args);
  XML_StopParser(parser_, XML_FALSE);
}

Status XmlParser::parse(std::span<const char> piece, bool last, const ByteInput& input, const char* part) {
  if (parser_ == nullptr) return input.fail(ErrorCode::kOutOfMemory, "no room for the XML parser");
  if (XML_Parse(parser_, piece.data(), static_cast<int>(piece.size()), last ? 1 : 0) == XML_STATUS_OK) return {};
  const auto line = static_cast<unsigned long long>(XML_GetCurrentLineNumber(parser_));
  if (complaint_[0] != 0) {
    return input.fail(ErrorCode::kMalformed, "line %llu of %s: %s;\texport the file again", line, part,
                      complaint_.data());
  }
  if (heap_.refused()) {
    return input.fail(ErrorCode::kUnsupported,
                      "line %llu of %s: tags too long or too deep for the memory;\texport only the object", line, part);
  }
  return input.fail(ErrorCode::kMalformed, "line %llu of %s: %s; the file is damaged.\tExport it again", line, part,
                    XML_ErrorString(XML_GetErrorCode(parser_)));
}

}  // namespace plumbline::inline slicer
