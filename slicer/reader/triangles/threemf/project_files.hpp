#pragma once
/// What a slicer's project says of its volumes and settings, beside the model.

#include <cstdint>
#include <span>
#include <string_view>

#include "slicer/reader/stream/xml_parser.hpp"
#include "slicer/reader/triangles/threemf/model_parts.hpp"
#include "slicer/reader/triangles/threemf/text_head.hpp"

namespace plumbline::inline slicer {

/// Too many volumes have a role.
void complain_of_volumes(XmlParser& parser);

/// Reads the roles of volumes: Metadata/Slic3r_PE_model.config of PrusaSlicer and those made from it, model_settings.config of Bambu Studio and
/// OrcaSlicer.
class ProjectDocument final : public XmlHandler {
 public:
  ProjectDocument(ModelParts& parts, UnusedSettings& project) : parts_(parts), project_(project) {}

  void begin(std::string_view name, const XmlAttributes& attributes) override;
  void end(std::string_view name) override;

 private:
  void see_type(std::string_view type);

  ModelParts& parts_;
  UnusedSettings& project_;
  std::uint64_t depth_ = 0;
  bool is_object_ = false, is_volume_ = false;
  std::uint32_t object_ = 0;
  ModelParts::Volume volume_;
};

/// Looks for settings that are not used, and for lists of holes or points, in the lines of a text.
class ProjectLines {
 public:
  explicit ProjectLines(UnusedSettings& project) : project_(project) {}

  void read(std::span<const char> piece);
  /// Call it after the last piece.
  void end_line();
  /// Of holes or points of some object.
  bool has_list() const { return has_list_; }

 private:
  UnusedSettings& project_;
  TextHead<64> line_;  ///< its beginning
  bool has_list_ = false;
};

}  // namespace plumbline::inline slicer
