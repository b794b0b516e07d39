#include "firmware/cli/options/grey_option.hpp"

#include <algorithm>
#include <vector>

namespace plumbline::firmware {

CLI::Option* add_grey_option(CLI::App& app, std::string& grey) {
  return app
      .add_option(
          "--grey", grey,
          "off: pixels are black or white; vertical: they are grey where the object begins, so that "
          "undersides lie between the heights of layers; full: also where walls pass through them, so that "
          "these lie between pixels. Takes a panel with grey_levels, or one with grey_exposures, which shows such "
          "a layer in several exposures [the profile's, or off]")
      ->type_name("KIND")
      ->check(CLI::IsMember(std::vector<std::string>(kGreyWords.begin(), kGreyWords.end())));
}

Status choose_grey(const std::string& grey, const BoardFile& board, const MachineFile& machine, PrintProfile& profile) {
  if (grey.empty()) return {};
  profile.grey = static_cast<Grey>(std::ranges::find(kGreyWords, grey) - kGreyWords.begin());
  if (profile.grey == Grey::kOff) return {};
  if (!machine.panel.grey.has_grey()) {
    return fail(ErrorCode::kBadSetting,
                "--grey %s: the panel of %s shows black and white only.\tLeave it out, or give [panel] grey_exposures",
                grey.c_str(), board.path.c_str());
  }
  if (!profile.exchange) {
    return fail(ErrorCode::kBadSetting,
                "--grey %s: the profile %s has no exchange in [resin], which says what light cures.\tAdd it, or leave "
                "out --grey",
                grey.c_str(), profile.name.c_str());
  }
  return {};
}

}  // namespace plumbline::firmware
