/// The program `plumbline-page`.

#include "firmware/page/page_command_line.hpp"

int main(int argc, char** argv) { return static_cast<int>(plumbline::firmware::run_page_command_line(argc, argv)); }
