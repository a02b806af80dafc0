#include <iostream>
#include <span>
#include <vector>

#include "sandbox/app/application.hpp"
#include "sandbox/cli/options.hpp"

int main(int argc, char** argv) {
    using namespace alpenglow::sandbox;
    const std::vector<const char*> arguments(argv + 1, argv + argc);
    const auto options = parse_options(arguments);
    if (!options) {
        std::cerr << "alpenglow-sandbox: " << options.error().message() << '\n';
        return static_cast<int>(Exit::bad_input);
    }
    return static_cast<int>(run(*options));
}
