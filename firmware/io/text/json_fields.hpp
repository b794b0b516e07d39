#pragma once
/// Tables of fields: what a report says of a struct, a row for each key.
///
///     constexpr JsonField<ProgressRecord> kProgress[] = {
///         {"layers", member<&ProgressRecord::layers>},
///         {"height_mm", rounded<&ProgressRecord::height_mm>},
///         {"ends_at", [](JsonWriter& json, const ProgressRecord& progress) { json.value(utc_text(progress.ends_at)); }},
///     };

#include <functional>
#include <string_view>

#include "firmware/io/text/json_writer.hpp"

namespace plumbline::firmware {

/// A key of an object that is made from a T, and the function that writes its value.
template <class T>
struct JsonField {
  std::string_view key;
  void (*write)(JsonWriter& json, const T& from);
};

/// JsonField::write of a member, or of what a function returns for a T.
template <auto of, class T>
void member(JsonWriter& json, const T& from) {
  json.value(std::invoke(of, from));
}

/// The same, rounded to three decimals.
template <auto of, class T>
void rounded(JsonWriter& json, const T& from) {
  json.value(thousandths(std::invoke(of, from)));
}

/// Writes the fields as members of the object that is open.
template <class Fields, class T>
void write_fields(JsonWriter& json, const Fields& fields, const T& from) {
  for (const auto& field : fields) {
    json.key(field.key);
    field.write(json, from);
  }
}

template <class Fields, class T>
void write_object(JsonWriter& json, const Fields& fields, const T& from, JsonWriter::Layout layout = kOneLine) {
  json.begin_object(layout);
  write_fields(json, fields, from);
  json.end_object();
}

/// The same for an optional or a pointer: null if it is empty.
template <class Fields, class T>
requires requires(const T& from) { *from; }
void write_object(JsonWriter& json, const Fields& fields, const T& from, JsonWriter::Layout layout = kOneLine) {
  if (!from) return json.null();
  write_object(json, fields, *from, layout);
}

/// An array of objects.
template <class Fields, class Items>
void write_objects(JsonWriter& json, const Fields& fields, const Items& items, JsonWriter::Layout layout = kOneLine) {
  json.begin_array(layout);
  for (const auto& item : items) write_object(json, fields, item);
  json.end_array();
}

/// JsonField::write of a member that has fields of its own.
template <auto of, const auto& fields, class T>
void object(JsonWriter& json, const T& from) {
  write_object(json, fields, std::invoke(of, from));
}

}  // namespace plumbline::firmware
