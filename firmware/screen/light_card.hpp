#pragma once
/// The card that says what each pattern of lights and buzzer means, as board/README.md prints it for the printer's front.

#include <array>
#include <cstddef>

#include "firmware/messages/catalogue.hpp"
#include "firmware/print/status/print_state.hpp"

namespace plumbline::firmware::inline screen {

/// One pattern. Its lights are those of `state`; all states that share them have the same row.
struct LightPattern {
  PrintState state;
  Words meaning;
};

inline constexpr std::array kLightPatterns{
    LightPattern{PrintState::kIdle, Words::kMeansReady},
    LightPattern{PrintState::kOffered, Words::kMeansOffered},
    LightPattern{PrintState::kSlicing, Words::kMeansBusy},
    LightPattern{PrintState::kPrinting, Words::kMeansPrinting},
    LightPattern{PrintState::kPaused, Words::kMeansPaused},
    LightPattern{PrintState::kFeedMe, Words::kMeansResin},
    LightPattern{PrintState::kInterrupted, Words::kMeansInterrupted},
    LightPattern{PrintState::kFinished, Words::kMeansFinished},
    LightPattern{PrintState::kPlateInUse, Words::kMeansPlate},
    LightPattern{PrintState::kFault, Words::kMeansFault},
    LightPattern{PrintState::kCancelled, Words::kMeansEnd},
};
inline constexpr std::size_t kLightPatternCount = kLightPatterns.size();

/// Whether lights and buzzer are the same in two states.
bool same_lights(PrintState a, PrintState b);
/// The row of a state.
std::size_t light_pattern_of(PrintState state);

}  // namespace plumbline::firmware::inline screen
