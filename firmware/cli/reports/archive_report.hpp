#pragma once
/// What `plumbline inspect` says of a sliced archive.

#include <string>

#include "firmware/archive/layer_archive.hpp"
#include "firmware/io/output_file.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/settings/job_options.hpp"

namespace plumbline::firmware {

/// @param refusal  why the printer can't print it; empty: it can, or there is no printer
Status write_archive_report(OutputFile& out, const LayerArchive& archive, const std::string& name,
                            const JobSetup& setup, const std::string& refusal);
void write_archive_report(JsonWriter& json, const LayerArchive& archive, const std::string& name, const JobSetup& setup,
                          const std::string& refusal);

}  // namespace plumbline::firmware
