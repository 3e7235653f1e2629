#include "answer/config.h"
#include "daemon/lcm_loop.h"
#include "daemon/lcm_receiver.h"
#include "daemon/multicast_receiver.h"
#include "daemon/real_time.h"
#include "robot/files/load.h"
#include "robot/files/strict_toml.h"
#include "text/printable.h"
#include "wire/bus_url.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <functional>
#include <memory>
#include <optional>
#include <poll.h>
#include <spdlog/async.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sysexits.h>
#include <system_error>
#include <systemd/sd-daemon.h>
#include <thread>

namespace
{

using namespace torqued;

// Something that ends the program before it runs, and the code it ends with.
struct Exit
{
  int code;
  std::string message;
};

// The command line over the configuration file over the defaults; nothing if the command line only asked for words.
std::optional<Config> configure(int argc, char** argv)
{
  CLI::App app{"torqued hears desired joint states of a planar biped on LCM and publishes the joint torques and ground "
               "reactions that produce them.",
               "torqued"};
  app.footer(
      "Example, on a bus of this machine alone:\n"
      "  LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0' torqued --robot human-subject01 --every-sample\n\n"
      "Exit codes: 0 ended by a signal, 64 wrong usage, 69 no bus, 78 bad configuration or robot, 1 anything else.");
  app.set_version_flag("--version", "torqued " TORQUED_VERSION);
  std::optional<std::string> file, robot, method, lcm_url, prefix, log_level;
  bool every_sample = false;
  bool print_config = false;
  app.add_option("--robot", robot,
                 fmt::format("a robot that ships ({}) or a .toml or .urdf file; no default",
                             fmt::join(shipped_robot_names(), ", ")))
      ->type_name("NAME|FILE");
  app.add_option("--config", file, "a TOML file that sets what flags do not")->type_name("FILE");
  app.add_option("--method", method,
                 fmt::format("how double support is resolved: {}; default: {}", method_names(),
                             name_of(MethodSettings().method)))
      ->type_name("NAME");
  app.add_option("--lcm-url", lcm_url, "the bus; default: LCM_DEFAULT_URL, or LCM's own default")->type_name("URL");
  app.add_option("--prefix", prefix, "stands before each channel's name")->type_name("TEXT");
  app.add_flag("--every-sample", every_sample,
               "answer all samples in order, for recorded trajectories, not the newest");
  app.add_option("--log-level", log_level, "trace, debug, info, warn, error, critical or off; default: info")
      ->type_name("LEVEL");
  app.add_flag("--print-config", print_config, "print the whole effective configuration as TOML, and end");
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::ParseError& error)
  {
    if (error.get_exit_code() != 0)
      throw Exit{EX_USAGE, fmt::format("{}; torqued --help says what is right", error.what())};
    app.exit(error);
    return {};
  }

  Config config = file ? read_config(*file) : Config();
  const auto set = [&config](std::string_view option, auto setter, const std::optional<std::string>& value)
  {
    try
    {
      if (value)
        setter(config, *value);
    }
    catch (const std::invalid_argument& error)
    {
      throw Exit{EX_USAGE, fmt::format("{}: {}", option, error.what())};
    }
  };
  config.robot = robot.value_or(config.robot);
  if (lcm_url)
  {
    config.lcm_url = *lcm_url;
    config.lcm_url_set_by = "--lcm-url";
  }
  set("--method", set_method, method);
  set("--prefix", set_prefix, prefix);
  set("--log-level", set_log_level, log_level);
  config.every_sample |= every_sample;
  if (print_config)
  {
    fmt::print("{}", to_toml(config));
    return {};
  }
  return config;
}

// A file that SIGTERM, SIGINT and SIGHUP make readable. What has not ended by itself soon after that, because something
// blocks it — the bus, a full disk, a terminal that nobody reads — is ended here. To be called before any other thread
// starts, so that all of them leave the signals to this one. A terminal that is closed ends nothing if nohup, or
// whoever started us, had SIGHUP ignored.
int end_by_signal()
{
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  struct sigaction hang_up;
  if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN)
    sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  const int stop_fd = eventfd(0, EFD_CLOEXEC);
  std::thread(
      [signals, stop_fd]
      {
        int signal = 0;
        sigwait(&signals, &signal);
        eventfd_write(stop_fd, 1);
        std::this_thread::sleep_for(std::chrono::milliseconds(60));
        std::_Exit(EX_OK);
      })
      .detach();
  return stop_fd;
}

// The message of a line of the log, as a terminal may show it: texts from outside are part of some.
class PrintableMessage : public spdlog::custom_flag_formatter
{
public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& line) override
  {
    append_printable_line(line, std::string_view(message.payload.data(), message.payload.size()));
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override { return std::make_unique<PrintableMessage>(); }
};

// spdlog's own lines, but for their message.
std::unique_ptr<spdlog::formatter> printable_formatter()
{
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PrintableMessage>('*').set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*");
  return formatter;
}

// The motors without a torque limit, or "any motor".
std::string without_torque_limit(const Robot& robot)
{
  std::vector<std::string> names;
  for (const Actuator& actuator : robot.actuators)
    if (std::isinf(actuator.torque_limit))
      names.push_back(actuator.name);
  return names.size() == robot.actuators.size() && !names.empty() ? "any motor"
                                                                  : fmt::format("{}", fmt::join(names, ", "));
}

// What tells systemd that the loop is healthy, from a thread of its own: where systemd is slow, it alone waits. Call it
// after end_by_signal().
std::function<void()> watchdog_beat()
{
  if (std::getenv("NOTIFY_SOCKET") == nullptr)
    return [] {
    };
  static std::atomic<bool> healthy = false;
  std::thread(
      []
      {
        while (true)
        {
          healthy.wait(false);
          healthy = false;
          sd_notify(0, "WATCHDOG=1");
        }
      })
      .detach();
  return []
  {
    healthy = true;
    healthy.notify_one();
  };
}

// Multicast is heard by a socket of our own, every other kind of bus by LCM's library.
std::unique_ptr<Receiver> open_receiver(lcm::LCM& bus, const Config& config)
try
{
  const BusUrl url = read_bus_url(choose_bus(config.lcm_url, config.lcm_url_set_by).url);
  if (url.provider == BusUrl::Provider::udpm)
    return std::make_unique<MulticastReceiver>(url);
  return std::make_unique<LcmReceiver>(bus);
}
catch (const std::system_error& error)
{
  throw Exit{EX_UNAVAILABLE, fmt::format("the LCM bus cannot be heard: {}; {}", error.code().message(),
                                         bus_trouble(config.lcm_url, config.lcm_url_set_by))};
}

std::string real_time(const Config& config)
try
{
  return enter_real_time(config);
}
catch (const std::runtime_error& error)
{
  throw Exit{EX_CONFIG, error.what()};
}

int serve(const Config& config)
{
  if (config.robot.empty())
    throw Exit{EX_CONFIG, fmt::format("no robot is said: say --robot NAME|FILE, or robot = \"NAME\" in the file of "
                                      "--config (robots that ship: {})",
                                      fmt::join(shipped_robot_names(), ", "))};
  const Robot robot = load_robot(config.robot);
  check_fits(config, robot);
  const int stop_fd = end_by_signal();
  spdlog::init_thread_pool(1024, 1);
  const auto log = spdlog::create_async_nb<spdlog::sinks::stderr_color_sink_mt>("torqued");
  log->set_formatter(printable_formatter());
  log->set_level(spdlog::level::from_str(config.log_level));
  const std::function<void()> on_healthy = watchdog_beat();
  const std::string effects = real_time(config); // all threads but this one run already

  if (const std::string fault = fault_between_processes(choose_bus(config.lcm_url, config.lcm_url_set_by));
      !fault.empty())
    throw Exit{EX_UNAVAILABLE, fmt::format("the LCM bus cannot be opened: {}", fault)};
  const std::string trouble = bus_trouble(config.lcm_url, config.lcm_url_set_by);
  lcm::LCM bus(config.lcm_url);
  if (!bus.good())
    throw Exit{EX_UNAVAILABLE, fmt::format("the LCM bus cannot be opened: {}", trouble)};
  const std::unique_ptr<Receiver> receiver = open_receiver(bus, config);
  LcmLoop loop(
      bus, *receiver, robot, config, *log,
      {.dropped_logs = [pool = spdlog::thread_pool()] { return static_cast<std::int64_t>(pool->overrun_counter()); },
       .on_healthy = on_healthy});
  if (!loop.prove_bus(stop_fd) || !loop.listen())
  {
    if (pollfd stop{stop_fd, POLLIN, 0}; poll(&stop, 1, 0) > 0)
      return EX_OK;
    throw Exit{EX_UNAVAILABLE,
               fmt::format("the LCM bus does not carry messages, not even to this process itself: {}", trouble)};
  }
  log->info("answering {} on {}TORQUED_DESIRED, {:.1f} kg, {} joints, method {}", robot.name, config.prefix,
            robot.mechanism.mass(), robot.num_joints(), name_of(config.answers.methods.method));
  if (!effects.empty())
    log->info("real time: {}", effects);
  for (const std::string& note : robot.notes)
    log->warn(note);
  if (std::ranges::none_of(robot.feet, [](const Foot& foot) { return foot.exists(); }))
    log->warn("{} has no feet: no contact with the ground is possible; a TOML file with [[foot]] tables gives it some",
              robot.name);
  if (const std::string unlimited = without_torque_limit(robot); !unlimited.empty())
    log->warn("{} has no torque limit for {}: what is asked of these motors is bounded only by {} times weight times "
              "leg length; torque_limit in the robot's file gives them one",
              robot.name, unlimited, kMostTorque);
  flush_denormals();
  sd_notify(0, "READY=1");
  loop.run(stop_fd);
  sd_notify(0, "STOPPING=1");
  log->info("stopped");
  spdlog::shutdown();
  return EX_OK;
}

// By the C library: fmt would throw where nobody reads stderr, and end by SIGABRT.
int complain(int code, const std::string& message)
{
  std::fputs(("torqued: " + printable_line(message) + "\n").c_str(), stderr);
  return code;
}

} // namespace

int main(int argc, char** argv)
try
{
  std::signal(SIGPIPE, SIG_IGN); // a log whose reader has gone ends nothing
  const std::optional<Config> config = configure(argc, argv);
  return config ? serve(*config) : EX_OK;
}
catch (const Exit& exit)
{
  return complain(exit.code, exit.message);
}
catch (const FileError& error)
{
  return complain(EX_CONFIG, error.what());
}
catch (const std::exception& error)
{
  return complain(EXIT_FAILURE, error.what());
}
