#include "slicer/reader/formats/e57/e57_xml.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <new>
#include <string_view>

#include "slicer/reader/stream/words.hpp"
#include "slicer/reader/stream/xml_parser.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "reading E57";

/// More scans or fields than any scanner writes for an object that can be printed.
constexpr std::size_t kMostE57Scans = 192;

/// Follows the elements e57Root / data3D / scan / pose and points.
class E57Document final : public XmlHandler {
 public:
  explicit E57Document(std::span<E57Scan> room) : room_(room) {}

  std::span<E57Scan> scans() const { return room_.first(count_); }

  void begin(std::string_view name, const XmlAttributes& attributes) override {
    ++depth_;
    if (depth_ == 2) in_scans_ = name == "data3D";
    if (!in_scans_) return;
    if (depth_ == 3) begin_scan();
    if (depth_ == 4) part_ = name == "pose" ? Part::kPose : name == "points" ? Part::kPoints : Part::kOther;
    if (part_ == Part::kPose && depth_ >= 5) begin_pose(name);
    if (part_ == Part::kPoints && depth_ == 4) begin_points(attributes);
    if (part_ == Part::kPoints && depth_ == 5) {
      in_prototype_ = name == "prototype";
      in_codecs_ = name == "codecs";
    }
    if (part_ == Part::kPoints && depth_ >= 6 && in_prototype_) add_field(name, attributes);
    if (part_ == Part::kPoints && (depth_ == 6 || depth_ == 7) && in_codecs_) check_codec(name);
  }

  void text(std::string_view piece) override {
    if (value_ == nullptr || depth_ != 6) return;
    const std::size_t count = std::min(piece.size(), text_.size() - text_size_);
    std::copy_n(piece.begin(), count, text_.begin() + static_cast<std::ptrdiff_t>(text_size_));
    text_size_ += count;
    if (count < piece.size()) parser_->complain("a number of a pose is too long");
  }

  void end(std::string_view /*name*/) override {
    if (value_ != nullptr && depth_ == 6) {
      const auto word = LineWords({text_.data(), text_size_}, kXmlBlanks).next();
      if (!word.empty() && !parse_number(word, *value_))
        parser_->complain("'%s' is not a number of a pose", Quote(word).c_str());
      value_ = nullptr;
    }
    if (in_scans_ && depth_ == 3) end_scan();
    if (depth_ == 4) part_ = Part::kOther;
    --depth_;
  }

 private:
  enum class Part : std::uint8_t { kOther, kPose, kPoints };
  using Fields = std::array<E57Field, 3>;
  using Kind = E57Field::Kind;

  void begin_scan() {
    scan_ = {};
    rotation_ = {1, 0, 0, 0};
    cartesian_ = spherical_ = normal_ = {};
    cartesian_invalid_ = spherical_invalid_ = {};
    has_points_ = false;
    part_ = Part::kOther;
  }

  /// Zeros may be left out of a rotation or a translation.
  void begin_pose(std::string_view name) {
    if (depth_ == 5) {
      is_rotation_ = name == "rotation";
      is_translation_ = name == "translation";
      if (is_rotation_) rotation_ = {};
      return;
    }
    value_ = nullptr;
    text_size_ = 0;
    if (depth_ > 6 || name.size() != 1) return;
    constexpr std::string_view kAxes = "xyz";
    const std::size_t axis = kAxes.find(name[0]);
    if (is_rotation_ && name == "w") value_ = &rotation_[0];
    if (axis == std::string_view::npos) return;
    if (is_rotation_) value_ = &rotation_[1 + axis];
    if (is_translation_) value_ = &scan_.pose.translation[static_cast<int>(axis)];
  }

  void begin_points(const XmlAttributes& attributes) {
    has_points_ = true;
    in_prototype_ = in_codecs_ = false;
    if (!parse_number(attributes["fileOffset"], scan_.section) ||
        !parse_number(attributes["recordCount"], scan_.points)) {
      parser_->complain("points without a usable fileOffset and recordCount");
    }
  }

  /// Each entry lists the fields that a codec packs, and the codec. Fields that no entry lists are bit-packed.
  void check_codec(std::string_view name) {
    if (name == "vectorChild" || name == "inputs" || name == "bitPackCodec") return;
    parser_->complain("points packed by '%s'; only 'bitPackCodec' is read", Quote(name).c_str());
  }

  /// Elements with others in them have no stream of their own.
  void add_field(std::string_view name, const XmlAttributes& attributes) {
    const auto type = attributes["type"];
    if (type == "Structure" || type == "Vector") return;
    if (scan_.streams == kE57MostStreams) return parser_->complain("points of more than %zu fields", kE57MostStreams);
    E57Field* const field = depth_ == 6 ? wanted(name) : nullptr;
    if (field != nullptr && field->kind == Kind::kNone) *field = parse_field(name, type, attributes);
    ++scan_.streams;
  }

  E57Field* wanted(std::string_view name) {
    static constexpr std::string_view kCartesian[] = {"cartesianX", "cartesianY", "cartesianZ"};
    static constexpr std::string_view kSpherical[] = {"sphericalRange", "sphericalAzimuth", "sphericalElevation"};
    static constexpr std::string_view kNormal[] = {":normalX", ":normalY", ":normalZ"};
    for (std::size_t a = 0; a < 3; ++a) {
      if (name == kCartesian[a]) return &cartesian_[a];
      if (name == kSpherical[a]) return &spherical_[a];
      if (name.ends_with(kNormal[a])) return &normal_[a];  // whatever the prefix of the extension is
    }
    if (name == "rowIndex" || name == "columnIndex") scan_.is_placed = true;
    if (name == "cartesianInvalidState") return &cartesian_invalid_;
    if (name == "sphericalInvalidState") return &spherical_invalid_;
    return nullptr;
  }

  E57Field parse_field(std::string_view name, std::string_view type, const XmlAttributes& attributes) {
    E57Field field;
    field.stream = static_cast<std::uint16_t>(scan_.streams);
    if (type == "Float") {
      const bool single = attributes["precision"] == "single";
      field.kind = single ? Kind::kFloat : Kind::kDouble;
      field.bits = single ? 32 : 64;
      return field;
    }
    if (type != "Integer" && type != "ScaledInteger") {
      parser_->complain("'%s' is of type '%s'", Quote(name).c_str(), Quote(type).c_str());
      return field;
    }
    field.kind = Kind::kInteger;
    field.minimum = std::numeric_limits<std::int64_t>::min();
    std::int64_t maximum = std::numeric_limits<std::int64_t>::max();
    const auto usable = [&](const char* key, auto& number) {
      return attributes[key].empty() || parse_number(attributes[key], number);
    };
    bool good = usable("minimum", field.minimum) && usable("maximum", maximum) && field.minimum <= maximum;
    if (type == "ScaledInteger") {
      good = good && usable("scale", field.scale) && usable("offset", field.offset) && field.scale != 0;
    }
    if (!good) parser_->complain("'%s' has no usable range or scale", Quote(name).c_str());
    field.bits = static_cast<std::uint8_t>(
        std::bit_width(static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(field.minimum)));
    return field;
  }

  static bool are_all(const Fields& fields) {
    return std::all_of(fields.begin(), fields.end(), [](const E57Field& f) { return f.kind != Kind::kNone; });
  }

  void end_scan() {
    scan_.is_spherical = !are_all(cartesian_);
    const Fields& position = scan_.is_spherical ? spherical_ : cartesian_;
    if (!has_points_ || scan_.points == 0 || !are_all(position)) return;
    std::copy(position.begin(), position.end(), scan_.field.begin() + kE57X);
    if (are_all(normal_)) std::copy(normal_.begin(), normal_.end(), scan_.field.begin() + kE57Nx);
    scan_.field[kE57Invalid] = scan_.is_spherical ? spherical_invalid_ : cartesian_invalid_;
    if (std::all_of(position.begin(), position.end(), [](const E57Field& f) { return f.bits == 0; })) {
      return parser_->complain("all points of a scan are at one place");
    }
    const auto [w, x, y, z] = rotation_;
    const auto rotation = rotation_of(w, x, y, z);
    if (!rotation) return parser_->complain("a pose has a rotation of length 0");
    scan_.pose.rotation = *rotation;
    scan_.is_placed |= scan_.is_spherical || scan_.pose.translation != Vec3d::Zero() || *rotation != Mat3d::Identity();
    if (count_ == room_.size()) return parser_->complain("more than %zu scans", room_.size());
    room_[count_++] = scan_;
  }

  std::span<E57Scan> room_;
  std::size_t count_ = 0;

  std::uint64_t depth_ = 0;  ///< of the open element, from 1
  bool in_scans_ = false;
  Part part_ = Part::kOther;
  bool in_prototype_ = false, in_codecs_ = false;
  bool is_rotation_ = false, is_translation_ = false;
  double* value_ = nullptr;  ///< of the pose, whose text is being read
  std::array<char, 64> text_ = {};
  std::size_t text_size_ = 0;

  E57Scan scan_;
  bool has_points_ = false;
  std::array<double, 4> rotation_ = {};  ///< w, x, y, z
  Fields cartesian_, spherical_, normal_;
  E57Field cartesian_invalid_, spherical_invalid_;
};

/// @param room  for the scans
Expected<std::span<E57Scan>> parse_xml(E57Pages& pages, std::uint64_t bytes, std::span<E57Scan> room, FixedHeap& heap) {
  E57Document document(room);
  XmlParser parser(heap, document);
  for (std::uint64_t left = bytes; left > 0;) {
    const auto piece = pages.next(left);
    PLUMBLINE_TRY(piece);
    left -= piece->size();
    PLUMBLINE_TRY(parser.parse(*piece, left == 0, pages.input(), "its XML"));
  }
  return document.scans();
}

}  // namespace

Expected<std::span<E57Scan>> read_e57_xml(E57Pages& pages, std::uint64_t bytes, Arena& memory) {
  const auto room = memory.take_bottom<E57Scan>(kMostE57Scans, kStage);
  PLUMBLINE_TRY(room);
  std::uninitialized_default_construct(room->begin(), room->end());
  const std::size_t mark = memory.bottom_mark();
  const auto block = memory.take_bottom<std::byte>(memory.available() / Arena::kAlignment * Arena::kAlignment, kStage);
  PLUMBLINE_TRY(block);
  FixedHeap heap(*block);
  const auto scans = parse_xml(pages, bytes, *room, heap);
  memory.release_bottom(mark);
  return scans;
}

}  // namespace plumbline::inline slicer
