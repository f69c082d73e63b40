//! Coordination laws of other papers, beside those of [`cohold_core`], under the same trait: each is a file with its equations, its
//! promise and its own keys.
//!
//! [`OtherLaw`] is any of them, for a simulator that has core's laws already; [`EveryLaw`] any of them or of core's, for a board.
//! A law that is added is a line in both lists, and one of core's a line in the second; a test says which is missing. Several keep an
//! account of energy, which is one mechanism ([`tank`]).
#![no_std]
#![forbid(unsafe_code)]

#[macro_use]
extern crate cohold_core;

pub mod average_position;
pub mod deadband;
pub mod fractal_impedance;
pub mod model_mediated;
pub mod passive_spring;
pub mod passivity_observer;
pub mod remote_dynamic_proxy;
pub mod set_position;
pub mod tank;
pub mod two_layer;
pub mod wave_compensator;
pub mod wave_integral;

use cohold_core::law::{Law, LawInfo, four_channel, free, p_plus_d, power, self_timed, wave};

/// The examples of the page that registries show.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

laws! {
    /// Any law of this crate; each is described on the page of its module.
    pub enum OtherLaw, OtherLawState {
        SetPosition(set_position::SetPosition<S>),
        PassiveSpring(passive_spring::PassiveSpring<S>),
        TwoLayer(two_layer::TwoLayer<S>),
        WaveIntegral(wave_integral::WaveIntegral<S>),
        WaveCompensator(wave_compensator::WaveCompensator<S>),
        AveragePosition(average_position::AveragePosition<S>),
        RemoteDynamicProxy(remote_dynamic_proxy::RemoteDynamicProxy<S>),
        FractalImpedance(fractal_impedance::FractalImpedance<S>),
        Deadband(deadband::Deadband<S>),
        PassiveDeadband(deadband::PassiveDeadband<S>),
        PassivityObserver(passivity_observer::PassivityObserver<S>),
        ModelMediated(model_mediated::ModelMediated<S>),
    }
}

laws! {
    /// Any law of this crate or of [`cohold_core`].
    pub enum EveryLaw, EveryLawState {
        Power(power::Power<S>),
        PPlusD(p_plus_d::PPlusD<S>),
        Wave(wave::Wave<S>),
        PassiveWave(wave::PassiveWave<S>),
        PassiveMean(wave::PassiveMean<S>),
        SelfTimed(self_timed::SelfTimed<S>),
        SetPosition(set_position::SetPosition<S>),
        PassiveSpring(passive_spring::PassiveSpring<S>),
        TwoLayer(two_layer::TwoLayer<S>),
        WaveIntegral(wave_integral::WaveIntegral<S>),
        WaveCompensator(wave_compensator::WaveCompensator<S>),
        FourChannel(four_channel::FourChannel<S>),
        AveragePosition(average_position::AveragePosition<S>),
        RemoteDynamicProxy(remote_dynamic_proxy::RemoteDynamicProxy<S>),
        FractalImpedance(fractal_impedance::FractalImpedance<S>),
        Deadband(deadband::Deadband<S>),
        PassiveDeadband(deadband::PassiveDeadband<S>),
        PassivityObserver(passivity_observer::PassivityObserver<S>),
        ModelMediated(model_mediated::ModelMediated<S>),
        Free(free::Free),
    }
}

/// What every law of core and of this crate says of itself.
pub const LAWS: &[LawInfo] = <EveryLaw<f64> as Law<f64>>::LAWS;
