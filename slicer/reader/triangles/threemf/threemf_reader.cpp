#include <algorithm>
#include <cmath>

#include "slicer/reader/stream/words.hpp"
#include "slicer/reader/stream/xml_parser.hpp"
#include "slicer/reader/triangles/threemf/model_copy.hpp"
#include "slicer/reader/triangles/threemf/model_parts.hpp"
#include "slicer/reader/triangles/threemf/project_files.hpp"
#include "slicer/reader/triangles/threemf/text_head.hpp"
#include "slicer/reader/triangles/threemf/zip_parts.hpp"
#include "slicer/reader/triangles/triangle_formats.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "reading 3MF";

/// Share of the progress that the first pass takes: it finds what stands where. If it also copies the meshes, no second one reads them.
constexpr double kFirstPass = 0.4;
constexpr double kOnlyPass = 0.9;

struct Unit {
  std::string_view name;
  double mm;
};
constexpr std::array<Unit, 6> kUnits = {
    {{"micron", 0.001}, {"millimeter", 1}, {"centimeter", 10}, {"inch", 25.4}, {"foot", 304.8}, {"meter", 1000}}};

/// Extensions that may be required: paths to other parts, colours, marked triangles, contours for other printers. Whatever else a file
/// requires changes its shape.
constexpr std::array<std::string_view, 4> kHarmlessExtensions = {"/production/", "/material/", "/trianglesets/",
                                                                 "/slice/"};

/// Settings of Cura that make an object no solid.
constexpr std::array<std::string_view, 4> kCuraModifiers = {"infill_mesh", "cutting_mesh", "support_mesh",
                                                            "anti_overhang_mesh"};

/// An element's name without its prefix.
std::string_view local_name(std::string_view name) { return name.substr(name.find(':') + 1); }

/// Follows the elements model / resources / object / mesh or components, and model / build.
class ModelDocument : public XmlHandler {
 public:
  ModelDocument(std::uint64_t part, ModelParts& parts) : part_(part), parts_(parts) {}

  double unit_mm() const { return unit_mm_; }

  void begin(std::string_view name, const XmlAttributes& attributes) override {
    name = local_name(name);
    ++depth_;
    switch (depth_) {
      case 1: begin_model(name, attributes); break;
      case 2:
        is_resources_ = name == "resources";
        is_build_ = name == "build";
        break;
      case 3:
        is_item_ = is_build_ && name == "item";
        if (is_item_) place(attributes, {part_, 0});
        is_object_ = is_resources_ && name == "object";
        if (is_object_) begin_object_element(attributes);
        break;
      case 4:
        is_mesh_ = is_object_ && name == "mesh";
        is_components_ = is_object_ && name == "components";
        break;
      case 5:
        if (is_components_ && name == "component") place(attributes, object_);
        if (is_object_ || is_item_) begin_setting(name, attributes);
        if (is_mesh_ && name == "beamlattice") beams();
        list_ = !is_mesh_             ? List::kOther
                : name == "vertices"  ? List::kVertices
                : name == "triangles" ? List::kTriangles
                                      : List::kOther;
        break;
      case 6:
        if (list_ == List::kVertices && name == "vertex") vertex(attributes);
        if (list_ == List::kTriangles && name == "triangle") triangle(attributes);
        break;
      default: break;
    }
  }

  void end(std::string_view /*name*/) override {
    if (depth_ == 3 && is_object_) end_object();
    if (depth_ == 5 && is_modifier_) end_setting();
    if (depth_ == 4) is_mesh_ = is_components_ = false;
    if (depth_ == 5) list_ = List::kOther;
    --depth_;
  }
  void text(std::string_view piece) override {
    if (is_modifier_) value_.append(piece);
  }

 protected:
  virtual void begin_object(const ObjectKey& /*key*/, bool /*printed*/) {}
  virtual void end_object() {}
  virtual void vertex(const XmlAttributes& /*attributes*/) {}
  virtual void triangle(const XmlAttributes& /*attributes*/) {}
  virtual void beams() {}
  virtual void no_solid(const ModelParts::Volume& /*volume*/) {}
  virtual void placed(const ObjectKey& /*child*/, const ObjectKey& /*in*/, const Affine& /*place*/) {}

  ModelParts& parts() { return parts_; }

 private:
  enum class List : std::uint8_t { kOther, kVertices, kTriangles };

  void begin_model(std::string_view name, const XmlAttributes& attributes) {
    if (name != "model") return parser_->complain("expected a model, found '%s'", Quote(name).c_str());
    if (const auto unit = attributes["unit"]; !unit.empty()) {
      const auto known = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.name == unit; });
      if (known == kUnits.end()) return parser_->complain("unknown unit '%s'", Quote(unit).c_str());
      unit_mm_ = known->mm;
    }
    LineWords required(attributes["requiredextensions"]);
    for (auto prefix = required.next(); !prefix.empty(); prefix = required.next()) {
      const auto space = attributes.any(prefix);
      const auto is_harmless = [&](std::string_view part) { return space.find(part) != std::string_view::npos; };
      if (std::any_of(kHarmlessExtensions.begin(), kHarmlessExtensions.end(), is_harmless)) continue;
      return parser_->complain("the model needs the extension '%s' of 3MF, which is not supported",
                               Quote(prefix).c_str());
    }
  }

  void begin_object_element(const XmlAttributes& attributes) {
    object_ = {part_, number(attributes["id"], "an object's id")};
    const auto type = attributes["type"];
    begin_object(object_, type.empty() || type == "model" || type == "solidsupport");
  }

  /// Cura's settings of an object or an item: a metadata of 3MF, or an element of its own before version 3.
  void begin_setting(std::string_view name, const XmlAttributes& attributes) {
    if (name != "metadata" && name != "setting") return;
    const auto key = local_name(attributes[name == "setting" ? "key" : "name"]);
    is_modifier_ = std::ranges::find(kCuraModifiers, key) != kCuraModifiers.end();
    value_ = {};
  }
  void end_setting() {
    is_modifier_ = false;
    if (value_.view() != "True" && value_.view() != "true" && value_.view() != "1") return;
    if (is_object_) no_solid({.in = object_});
    if (is_item_) no_solid({.in = {part_, 0}, .child = item_});
  }

  void place(const XmlAttributes& attributes, const ObjectKey& in) {
    if (attributes.any("printable") == "0") return;  // PrusaSlicer's
    const auto path = attributes.any("path");
    const ObjectKey child{path.empty() ? part_ : part_key(path), number(attributes["objectid"], "an objectid")};
    const auto transform = parse_transform(attributes["transform"]);
    if (!transform)
      return parser_->complain("'%s' is not a transform of 12 numbers", Quote(attributes["transform"]).c_str());
    if (in.id == 0) item_ = child.id;
    placed(child, in, *transform);
  }

  std::uint32_t number(std::string_view text, const char* wanted) {
    std::uint32_t value = 0;
    if (!parse_number(text, value) || value == 0) {
      parser_->complain("expected %s from 1, found '%s'", wanted, Quote(text).c_str());
    }
    return value;
  }

  std::uint64_t part_;
  ModelParts& parts_;
  double unit_mm_ = 1;
  std::uint64_t depth_ = 0;  ///< of the open element, from 1
  bool is_resources_ = false, is_build_ = false;
  bool is_object_ = false, is_item_ = false, is_mesh_ = false, is_components_ = false;
  bool is_modifier_ = false;  ///< the open element is one of kCuraModifiers
  TextHead<8> value_;         ///< of it
  std::uint32_t item_ = 0;    ///< id of the last item's object
  List list_ = List::kOther;
  ObjectKey object_;
};

/// Parses three attributes.
/// @returns the first one that is no number, if there is any
template <class Number>
std::optional<std::string_view> parse_three(const XmlAttributes& attributes,
                                            const std::array<std::string_view, 3>& names,
                                            std::array<Number, 3>& numbers) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto text = attributes[names[i]];
    if (!parse_number(text, numbers[i])) return text;
  }
  return std::nullopt;
}
constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
constexpr std::array<std::string_view, 3> kCorners = {"v1", "v2", "v3"};

/// The first pass: what stands where, and a copy of all meshes.
class PlaceDocument final : public ModelDocument {
 public:
  PlaceDocument(std::uint64_t part, ModelParts& parts, ModelCopy& copy) : ModelDocument(part, parts), copy_(copy) {}

 private:
  // What can't be copied is no error here: perhaps it is not printed.
  void begin_object(const ObjectKey& key, bool printed) override {
    copy_.begin_object(key, printed);
    is_solid_ = printed;
  }
  void vertex(const XmlAttributes& attributes) override {
    if (!is_copied()) return;
    std::array<double, 3> p;
    if (parse_three(attributes, kAxes, p) || !copy_.add_vertex({p[0], p[1], p[2]})) copy_.give_up();
  }
  void triangle(const XmlAttributes& attributes) override {
    if (!is_copied()) return;
    std::array<std::uint64_t, 3> corners;
    if (parse_three(attributes, kCorners, corners) || !copy_.add_triangle(corners)) copy_.give_up();
  }
  void beams() override {
    if (is_copied()) copy_.give_up();
  }
  void placed(const ObjectKey& child, const ObjectKey& in, const Affine& place) override {
    if (parts().add(child, in, place)) return;
    parser_->complain("more than %zu items and components", ModelParts::kMostPlaces);
  }

  void no_solid(const ModelParts::Volume& volume) override {
    if (!parts().add(volume)) complain_of_volumes(*parser_);
  }

  bool is_copied() const { return is_solid_ && copy_.is_whole(); }

  ModelCopy& copy_;
  bool is_solid_ = false;
};

/// The second pass: the triangles of each mesh, as often as it is printed.
class MeshDocument final : public ModelDocument {
 public:
  MeshDocument(std::uint64_t part, ModelParts& parts, double unit_mm, TriangleBatch& batch, VertexList& vertices)
      : ModelDocument(part, parts), unit_mm_(unit_mm), batch_(batch), vertices_(vertices) {}

  /// What the sink or the list of vertices refused.
  const Status& status() const { return status_; }
  bool full() const { return full_; }

 private:
  void begin_object(const ObjectKey& key, bool printed) override {
    is_printed_ = false;
    if (!parts().declare(key)) return parser_->complain("another object with the id %u", key.id);
    if (!printed) return;
    const auto found = parts().find_instances(key);
    if (found == ModelParts::Found::kTooDeep) {
      return parser_->complain("components more than %u deep, or one that contains itself", ModelParts::kMostNested);
    }
    if (found == ModelParts::Found::kTooMany) {
      return parser_->complain("an object that is printed more than %zu times", ModelParts::kMostInstances);
    }
    is_printed_ = !parts().instances().empty();
    placed_.emplace(parts(), key, unit_mm_, batch_);
  }
  void end_object() override { count_vertices(vertices_, batch_.summary()); }

  void vertex(const XmlAttributes& attributes) override {
    if (!is_printed_) return;
    std::array<double, 3> p;
    if (const auto wrong = parse_three(attributes, kAxes, p)) {
      return parser_->complain("'%s' is not a coordinate", Quote(*wrong).c_str());
    }
    if (vertices_.add({p[0], p[1], p[2]})) return;
    full_ = true;
    parser_->complain("no room for another vertex");
  }

  void beams() override {
    if (is_printed_) parser_->complain("an object has a lattice of beams, which is not supported");
  }

  void triangle(const XmlAttributes& attributes) override {
    if (!is_printed_ || !status_) return;
    ++batch_.summary().faces;
    std::array<std::uint64_t, 3> corners;
    const auto wrong = parse_three(attributes, kCorners, corners);
    const auto is_missing = [&](std::uint64_t corner) { return corner >= vertices_.size(); };
    const auto missing = std::ranges::find_if(corners, is_missing);
    if (wrong || missing != corners.end()) {
      const auto text = wrong ? *wrong : attributes[kCorners[static_cast<std::size_t>(missing - corners.begin())]];
      return parser_->complain("a triangle names vertex '%s', but there are %llu, numbered from 0", Quote(text).c_str(),
                               static_cast<unsigned long long>(vertices_.size()));
    }
    Triangle t;
    for (std::size_t k = 0; k < 3; ++k) {
      vertices_.use(corners[k]);
      t[k] = vertices_.at(corners[k]);
    }
    status_ = placed_->add(t);
    if (!status_) parser_->complain("stopped");
  }

  double unit_mm_;
  TriangleBatch& batch_;
  VertexList& vertices_;
  std::optional<PlacedTriangles> placed_;  ///< of the open object
  bool is_printed_ = false;
  bool full_ = false;
  Status status_;
};

/// Finds the model that is printed among a file's relationships.
class RelationDocument final : public XmlHandler {
 public:
  explicit RelationDocument(ModelParts& parts) : parts_(parts) {}
  void begin(std::string_view name, const XmlAttributes& attributes) override {
    if (local_name(name) == "Relationship" && attributes["Type"].ends_with("/3dmodel")) {
      parts_.set_root(part_key(attributes["Target"]));
    }
  }
  void end(std::string_view /*name*/) override {}

 private:
  ModelParts& parts_;
};

/// What is the same of every 3MF.
void describe_3mf(MeshSummary& summary) {
  summary.format = ScanFormat::k3mf;
  summary.encoding = "zip";
  summary.is_in_mm = true;
}

/// (3MF Core Specification 1.3)
class ThreeMfReader {
 public:
  ThreeMfReader(ByteInput& input, TriangleBatch& batch, VertexList& vertices, ModelParts& parts, InflateStream& inflate,
                std::span<std::byte> heap, ModelCopy& copy)
      : input_(input), batch_(batch), vertices_(vertices), parts_(parts), inflate_(inflate), heap_(heap), copy_(copy) {}

  Status read() {
    MeshSummary& summary = batch_.summary();
    describe_3mf(summary);
    const double first_pass = copy_.is_whole() ? kOnlyPass : kFirstPass;
    input_.report_within(0, first_pass);
    PLUMBLINE_TRY(for_parts([&](ZipParts& part) { return read_places(part); }));
    const auto models = std::span(models_).first(model_count_);
    const auto root =
        std::find_if(models.begin(), models.end(), [&](const Model& m) { return m.part == parts_.root(); });
    if (root == models.end()) {
      return input_.fail(ErrorCode::kUnsupported,
                         "the archive has no 3D model (3D/3dmodel.model);\texport the object as 3MF or STL");
    }
    if (!parts_.places_anything()) {
      return telling(Told(ToldCode::kNoTriangles),
                     input_.fail(ErrorCode::kNoPoints,
                                 "no object is to be printed: its build has no item, or none that is printable;\tput "
                                 "an object on the plate in the program that wrote it, and export it again"));
    }
    unit_mm_ = root->unit_mm;
    parts_.assign_roles();
    parts_.count_roles(summary.project);
    if (copy_.finish(parts_, unit_mm_, input_.farthest(), summary.project)) {
      PLUMBLINE_TRY(copy_.deliver(parts_, batch_, first_pass));
    } else {
      PLUMBLINE_TRY(input_.rewind());
      input_.report_within(first_pass, 1);
      PLUMBLINE_TRY(for_parts([&](ZipParts& part) { return read_mesh_part(part); }));
    }
    if (const auto id = parts_.missing()) {
      return input_.fail(
          ErrorCode::kMalformed,
          "the object with the id %u is to be printed, but is not in the archive;\texport the file again", *id);
    }
    if (summary.faces == 0) {
      return telling(Told(ToldCode::kNoTriangles),
                     input_.fail(ErrorCode::kNoPoints,
                                 "what its build places has no triangle, or is a support, a surface or a modifier;\t"
                                 "export a solid object"));
    }
    return {};
  }

 private:
  template <class Use>
  Status for_parts(Use use) {
    ZipParts part(input_, inflate_);
    for (;;) {
      const auto found = part.next();
      PLUMBLINE_TRY(found);
      if (!*found) return {};
      PLUMBLINE_TRY(use(part));
    }
  }

  struct Model {
    std::uint64_t part = 0;
    double unit_mm = 1;
  };

  static bool is_model(const ZipParts& part) { return has_ending(part.name(), ".model"); }

  Status read_places(ZipParts& part) {
    if (part_key(part.name()) == part_key("_rels/.rels")) {
      RelationDocument relations(parts_);
      return parse(part, relations);
    }
    if (!is_model(part)) return read_project(part);
    const std::uint64_t key = part_key(part.name());
    PlaceDocument places(key, parts_, copy_);
    PLUMBLINE_TRY(parse(part, places));
    if (model_count_ == models_.size()) {
      return input_.fail(ErrorCode::kUnsupported,
                         "more than %zu models in one archive;\texport fewer objects at a time", models_.size());
    }
    models_[model_count_++] = {key, places.unit_mm()};
    return {};
  }

  Status read_project(ZipParts& part) {
    UnusedSettings& project = batch_.summary().project;
    const auto is = [&](std::string_view ending) { return has_ending(part.name(), ending); };
    if (is("_model.config") || is("model_settings.config")) {
      ProjectDocument document(parts_, project);
      return parse(part, document);
    }
    const bool holes = is("_sla_drain_holes.txt");
    const bool supports = is("_sla_support_points.txt");
    if (!holes && !supports && !is("/slic3r_pe.config")) return {};
    ProjectLines lines(project);
    for (;;) {
      const auto piece = part.read();
      PLUMBLINE_TRY(piece);
      if (piece->empty()) break;
      lines.read(*piece);
    }
    lines.end_line();
    project.drain_holes |= holes && lines.has_list();
    project.support_points |= supports && lines.has_list();
    return {};
  }

  Status read_mesh_part(ZipParts& part) {
    if (!is_model(part)) return {};
    MeshDocument meshes(part_key(part.name()), parts_, unit_mm_, batch_, vertices_);
    const Status read = parse(part, meshes);
    if (meshes.full()) return fail_vertices(input_, vertices_);
    if (!meshes.status()) return meshes.status();
    return read;
  }

  Status parse(ZipParts& part, XmlHandler& handler) {
    FixedHeap heap(heap_);
    XmlParser parser(heap, handler);
    const Quote name(part.name());
    for (;;) {
      const auto piece = part.read();
      PLUMBLINE_TRY(piece);
      PLUMBLINE_TRY(parser.parse(*piece, piece->empty(), input_, name.c_str()));
      if (piece->empty()) return {};
    }
  }

  ByteInput& input_;
  TriangleBatch& batch_;
  VertexList& vertices_;
  ModelParts& parts_;
  InflateStream& inflate_;
  std::span<std::byte> heap_;  ///< of the XML parser
  ModelCopy& copy_;
  std::array<Model, 512> models_;  ///< which of them is printed may be said after them
  std::size_t model_count_ = 0;
  double unit_mm_ = 1;  ///< of that model
};

}  // namespace

Status read_3mf(ByteInput& input, TriangleBatch& batch, const MeshRoom& room, ModelCopy& copy) {
  auto parts = ModelParts::create(room.memory);
  PLUMBLINE_TRY(parts);
  const auto window = room.memory.take_bottom<char>(InflateStream::kWindow, kStage);
  PLUMBLINE_TRY(window);
  const auto zlib = room.memory.take_bottom<std::byte>(InflateStream::kHeap, kStage);
  PLUMBLINE_TRY(zlib);
  const auto heap =
      room.memory.take_bottom<std::byte>(room.memory.available() / Arena::kAlignment * Arena::kAlignment, kStage);
  PLUMBLINE_TRY(heap);
  InflateStream inflate(input, InflateStream::Wrapping::kNone, *window, *zlib);
  return ThreeMfReader(input, batch, room.vertices, *parts, inflate, *heap, copy).read();
}

Status read_3mf_copy(const ModelCopy& copy, TriangleBatch& batch, Arena& memory) {
  describe_3mf(batch.summary());
  batch.summary().project = copy.project();
  auto parts = copy.parts(memory);
  PLUMBLINE_TRY(parts);
  return copy.deliver(*parts, batch, 0);
}

}  // namespace plumbline::inline slicer
