/// Smoothing of motions that were measured.
#pragma once

#include <Eigen/Core>

namespace torqued
{

/// Low-passes each column by a Butterworth filter of second order, forward and then backward, so that nothing lags:
///
///   |H(ω)|² = 1 / (1 + (tan(ω h / 2) / tan(π f h))⁴)          h = 1 / rate; f: cut_off
///
/// is the gain of both passes together, a half at the cut-off, which is that of one pass. Beyond its ends the motion
/// goes on for a second as its own image by a half turn about the end (x(−t) − x₀ = x₀ − x(t)), or for as long as the
/// motion is if that is less. A constant and a straight line stay as they are.
///
/// samples: one row per frame, two or more. rate: Hz. cut_off: Hz, above 0 and below rate / 2.
/// The same as scipy.signal.butter(2, cut_off, fs=rate) and filtfilt(…, padlen=rate).
/// Source: D. A. Winter, "Biomechanics and Motor Control of Human Movement", 4th edition, 2009, section 3.4.4.
Eigen::MatrixXd lowpass(const Eigen::MatrixXd& samples, double rate, double cut_off);

} // namespace torqued
